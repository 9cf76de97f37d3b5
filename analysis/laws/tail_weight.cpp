#include "analysis/laws/tail_weight.h"

#include <cmath>

#include "analysis/laws/hall_score.h"
#include "analysis/laws/student.h"
#include "core/nan.h"

namespace credence {

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

}  // namespace credence
