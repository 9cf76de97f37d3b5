#include "analysis/laws/correlation/lateness.h"

#include <cmath>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// Places in the averages of a run.
constexpr Index kAcross = 0, kMotion = 1, kError = 2, kVectors = 3;

// Of bᵀb what is left less the mean of b; of a stretch beside what is left of its run.
constexpr double kLeastVaried = 0.1, kLeastVariedStretch = 0.01;

LatenessTest no_lateness(std::int64_t runs, std::string_view reason) {
  return {.runs = runs, .steps = kNaN, .p_value = kNaN, .explained = kNaN, .reason = reason};
}

Index dim_of(const Vector& averages) { return (averages.size() - kVectors) / 2; }

// Of u over b with a mean of its own.
struct Slope {
  double across = 0.0, varied = 0.0;

  double steps() const { return -across / varied; }
};

Slope slope_of(const Vector& averages) {
  const Index dim = dim_of(averages);
  const auto u = averages.segment(kVectors, dim), b = averages.tail(dim);
  return {averages[kAcross] - u.dot(b), averages[kMotion] - b.squaredNorm()};
}

// |u|² − |u + d b|², with the motion as it is, of the excess of |u|².
double explained_by(double steps, const Vector& averages) {
  const double excess = averages[kError] - static_cast<double>(dim_of(averages));
  const double less = -2.0 * steps * averages[kAcross] - steps * steps * averages[kMotion];
  return excess > 0.0 ? less / excess : 0.0;
}

LatenessTest test_few_runs(const LatenessSums& sums) {
  constexpr std::int64_t kFewestSlopes = 3, kFewestStretches = 5;
  const bool of_runs = sums.run_slopes.count >= kFewestSlopes;
  const Moments& slopes = of_runs ? sums.run_slopes : sums.stretch_slopes;
  if (sums.run_slopes.count == 0) return no_lateness(sums.runs.count, kNoVariedMotion);
  if (!of_runs && slopes.count < kFewestStretches) {
    return no_lateness(sums.runs.count, "fewer than three runs, too short for stretches that turn");
  }
  const double n = static_cast<double>(slopes.count);
  const double steps = sums.run_slopes.mean;
  return {.runs = sums.runs.count,
          .steps = steps,
          .p_value = student_upper_p_value(slopes.mean / std::sqrt(slopes.variance() / n), n - 1.0),
          .explained = explained_by(steps, sums.runs.mean)};
}

}  // namespace

void RunLateness::add(const VectorRef& u, const VectorRef& b) {
  if (!u.allFinite() || !b.allFinite()) return;
  if (groups_.rows() == 0) dim_ = u.size();
  if (u.size() != dim_) return;
  Eigen::Map<Vector> sums = groups_.next(kVectors + 2 * dim_);
  for (Index i = 0; i < dim_; ++i) {
    sums[kAcross] += b[i] * u[i];
    sums[kMotion] += b[i] * b[i];
    sums[kError] += u[i] * u[i];
    sums[kVectors + i] += u[i];
    sums[kVectors + dim_ + i] += b[i];
  }
}

void RunLateness::add_to(LatenessSums& sums) const {
  if (groups_.rows() == 0) return;
  Vector averages = Vector::Zero(kVectors + 2 * dim_);
  for (Index g = 0; g < groups_.groups(); ++g) averages += groups_.of_group(g);
  averages /= static_cast<double>(groups_.rows());
  if (sums.runs.count > 0 && sums.runs.mean.size() != averages.size()) return;
  sums.runs.add(averages);
  const Slope slope = slope_of(averages);
  if (!(slope.varied > kLeastVaried * averages[kMotion])) return;
  sums.run_slopes.add(slope.steps());
  add_stretches(kLeastVariedStretch * slope.varied, sums);
}

void RunLateness::add_stretches(double least_varied, LatenessSums& sums) const {
  constexpr Index kStretches = 10, kFewestSteps = 5;
  const Index groups = groups_.rows() / groups_.rows_of_group() / kStretches;
  const Index steps = groups * groups_.rows_of_group();
  if (steps < kFewestSteps) return;
  Vector averages(kVectors + 2 * dim_);
  for (Index i = 0; i < kStretches; ++i) {
    averages.setZero();
    for (Index g = i * groups; g < (i + 1) * groups; ++g) averages += groups_.of_group(g);
    averages /= static_cast<double>(steps);
    const Slope slope = slope_of(averages);
    if (slope.varied > least_varied) sums.stretch_slopes.add(slope.steps());
  }
}

void LatenessSums::merge(const LatenessSums& later) {
  if (runs.count > 0 && later.runs.count > 0 && runs.mean.size() != later.runs.mean.size()) return;
  runs.merge(later.runs);
  run_slopes.merge(later.run_slopes);
  stretch_slopes.merge(later.stretch_slopes);
}

LatenessTest test_lateness(const LatenessSums& sums) {
  constexpr std::int64_t kFewest = 10;
  const VectorMoments& runs = sums.runs;
  if (runs.count == 0) return no_lateness(0, "no estimates are known beside the errors");
  if (!runs.mean.allFinite() || !runs.scatter.allFinite()) {
    return no_lateness(runs.count, "a value is not finite");
  }
  if (runs.count < kFewest) return test_few_runs(sums);
  const Index dim = dim_of(runs.mean);
  const Vector mean_motion = runs.mean.tail(dim);
  const double varied = runs.mean[kMotion] - mean_motion.squaredNorm();
  if (!(varied > kLeastVaried * runs.mean[kMotion])) {
    return no_lateness(runs.count, kNoVariedMotion);
  }
  Vector weights = Vector::Zero(runs.mean.size());
  weights[kAcross] = 1.0;
  weights.segment(kVectors, dim) = -mean_motion;
  const double n = static_cast<double>(runs.count);
  const double across = weights.dot(runs.mean);
  const double variance = weights.dot(runs.scatter * weights) / (n - 1.0);
  const double steps = -across / varied, t = -across / std::sqrt(variance / n);
  return {.runs = runs.count,
          .steps = steps,
          .p_value = student_upper_p_value(t, n - 1.0),
          .ahead_p_value = student_upper_p_value(-t, n - 1.0),
          .explained = explained_by(steps, runs.mean)};
}

}  // namespace credence::internal
