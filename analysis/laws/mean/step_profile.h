#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace credence::internal {

/// The p-value of "E ε_k/n_k = 1 at every step", whatever the law of the errors and their dependence in time:
/// a P that is too small at some steps and too large at others may be right on average.
///
/// Of each half of the runs, w_k is the sum of ε_k/n_k − 1 over that half, and s_i = Σ_k w_k (ε_ik/n_ik − 1)
/// of the runs of the other: its mean is 0 given w, and Σ_k w_k (E ε_k/n_k − 1) > 0 where both halves deviate
/// alike. Student's t over the runs, or over so many equal stretches of each, which are nearly independent,
/// one-sided, Bonferroni over the two halves. Runs may differ in length. NaN for a single run, or fewer than
/// twenty runs or stretches.
double step_profile_p_value(std::span<const std::vector<double>> normalised_nees, std::size_t stretches = 1);

}  // namespace credence::internal
