#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "analysis/evidence/verdicts/verdict.h"

/// @file
/// How often the truth lies in the kσ region that a covariance draws around the estimate (theory, section 7).
///
/// The truth is inside when NEES ≤ k²; a consistent filter of dof n does so with probability P(χ²(n) ≤ k²):
/// 68.3, 95.4, 99.7 % for k = 1, 2, 3 in one dimension, 39.3, 86.5, 98.9 % in two.

namespace credence::internal {

/// P(χ²(dof) ≤ k²). Throws std::invalid_argument unless k ≥ 0 and dof > 0.
double expected_coverage(double k_sigma, double dof);

/// How many of independent runs were inside; merges by adding both numbers.
struct CoverageCount {
  std::int64_t inside = 0;
  std::int64_t total = 0;

  void add(bool is_inside) {
    inside += is_inside ? 1 : 0;
    ++total;
  }
  void merge(const CoverageCount& other) {
    inside += other.inside;
    total += other.total;
  }
  bool operator==(const CoverageCount&) const = default;
};

/// A measured proportion with an interval.
struct ProportionInterval {
  double value = 0.0;
  double lower = 0.0;
  double upper = 1.0;
};

/// The interval of [Clopper 1934]: covers the true proportion with probability at least
/// `confidence`, whatever it is. Without trials [0, 1] and a NaN value. Throws std::invalid_argument unless
/// 0 ≤ inside ≤ total and 0 < confidence < 1.
ProportionInterval clopper_pearson(const CoverageCount& count, double confidence);

/// P(X ≥ count) of a binomial law.
double binomial_upper_tail(std::int64_t count, std::int64_t trials, double probability);

/// The two-sided exact binomial p-value of `count` under `probability`: twice the smaller tail, at most 1.
/// Conservative, as a count is discrete; 1 without trials.
double binomial_p_value(const CoverageCount& count, double probability);

/// The coverage of one step.
struct CoverageStep {
  CoverageCount count;
  ProportionInterval interval;  ///< pointwise, at `confidence`
  double expected = 0.0;
  double p_value = 0.0;
};

/// The coverage of all steps and one verdict.
struct CoverageVerdict {
  Verdict verdict = Verdict::undecided;  ///< optimistic: the truth is outside too often
  double p_value = 1.0;                  ///< of the worst step, adjusted for the number of steps
  std::int64_t worst_step = -1;
  std::int64_t tests = 0;  ///< steps with runs
  CoverageCount pooled;    ///< over steps: an estimate, without an interval (correlated in time)
  double expected = 0.0;   ///< of the pooled share
  std::vector<CoverageStep> steps;
};

/// Tests the coverage at every step, Bonferroni over the steps: valid for any correlation in time and
/// conservative, as counts are discrete. expected[k] is expected_coverage at step k. Throws
/// std::invalid_argument for sizes that differ or an expected coverage outside [0, 1].
CoverageVerdict judge_coverage(std::span<const CoverageCount> per_step, std::span<const double> expected,
                               double confidence);

}  // namespace credence::internal
