#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/chi_square/chi_square_cumulants.h"

/// @file
/// How a verdict is made from any laws of its sums: what judge_nees, judge_nis and their relatives share.

namespace credence::internal {

/// The law of a sum of values under consistency.
struct SumLaw {
  double expected = 0.0;
  std::function<ChiSquareBounds(double confidence)> bounds;
  std::function<double(double sum)> p_value;  ///< two-sided
};

/// χ²(dof).
SumLaw chi_square_law(double dof);

/// Σ χ²(dof_k), the terms dependent in any way (chi_square_dependent_sum.h).
SumLaw dependent_law(const std::vector<double>& dofs);

/// A law known by three cumulants (chi_square_cumulants.h).
SumLaw cumulant_law(const Cumulants& cumulants);

/// The laws of one verdict.
struct VerdictLaws {
  /// Of the sum over the runs at a step with this total dof and count; the same arguments, the same law.
  std::function<SumLaw(double total_dof, double count)> step;
  /// Of the sum over all tested steps.
  std::function<SumLaw(const std::vector<StepTest>& tested)> overall;
  std::string method;
  const RunAverages* runs = nullptr;  ///< compares these whole runs instead of `overall`
};

/// Joins the tests of every step and of the sum: the steps by Bonferroni, steps and sum each at half the
/// level. Input, errors and degenerate cases as judge_nees.
ConsistencyVerdict judge_sums(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                              double confidence, const VerdictLaws& laws);

}  // namespace credence::internal
