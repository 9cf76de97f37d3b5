#include "analysis/laws/shape/tail_weight.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {

void RunTails::add(double nees, double dof) {
  squares_ += nees * nees;
  expected_squares_ += dof * (dof + 2.0);
  sum_ += nees;
  dof_ += dof;
}

double RunTails::value() const {
  if (!(dof_ > 0.0)) return kNaN;
  return squares_ / expected_squares_ - 2.0 * sum_ / dof_ + 2.0;
}

double heavy_tail_p_value(const SkewedMoments& run_values) {
  constexpr std::int64_t kFewestRuns = 10;
  if (run_values.count < kFewestRuns || !(run_values.m2 > 0.0) || !std::isfinite(run_values.m3)) return kNaN;
  return student_upper_p_value(hall_score(run_values, 1.0), static_cast<double>(run_values.count - 1));
}

double far_tail_p_value(const CoverageCount& within, double quantile) {
  const double outside = static_cast<double>(within.total - within.inside);
  const double expected = (1.0 - quantile) * static_cast<double>(within.total);
  const double p = binomial_p_value(within, quantile);
  return outside > 10.0 * std::max(1.0, expected) ? p : 1.0;
}

}  // namespace credence::internal
