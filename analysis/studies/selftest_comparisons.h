#pragma once

#include <cstdint>
#include <vector>

#include "analysis/studies/selftest_filter.h"
#include "analysis/studies/selftest_tests.h"

/// @file
/// The tests of the commands that compare filters or tune one, by the code of these commands. Where the
/// filters are exact each is a false alarm.

namespace credence::internal {

/// `credence estimators` in a scalar linear world in which all are exact: any estimator at all by Holm, and
/// the difference of two on the same noise.
std::vector<TestResult> estimator_tests(std::uint64_t seed);

/// `credence compare` of the logs of two filters on the same noise: the changes of all factors by Holm.
std::vector<TestResult> log_comparison_tests(const SyntheticFilter& first, const SyntheticFilter& second,
                                             const NoiseSource& noise, std::int64_t block);

/// `credence tune` of a scalar linear world whose filter believes this many times the process noise that is
/// there: the likelihood ratio of the present noise, and of each factor whether its interval misses the true
/// one.
std::vector<TestResult> tuning_tests(std::uint64_t seed, double process_scale = 1.0);

}  // namespace credence::internal
