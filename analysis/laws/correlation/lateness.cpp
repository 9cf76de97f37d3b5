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

void RunLateness::add(const Vector& u, const Vector& b) {
  if (!u.allFinite() || !b.allFinite()) return;
  if (steps_ == 0) dim_ = u.size();
  if (u.size() != dim_) return;
  Vector& sums = group_at_hand();
  ++steps_;
  sums[kAcross] += b.dot(u);
  sums[kMotion] += b.squaredNorm();
  sums[kError] += u.squaredNorm();
  sums.segment(kVectors, dim_) += u;
  sums.tail(dim_) += b;
}

Vector& RunLateness::group_at_hand() {
  constexpr std::size_t kMostGroups = 64;
  if ((steps_ & (steps_of_group_ - 1)) != 0) return groups_.back();
  if (groups_.size() == kMostGroups) {
    for (std::size_t i = 0; i < kMostGroups / 2; ++i) groups_[i] = groups_[2 * i] + groups_[2 * i + 1];
    groups_.resize(kMostGroups / 2);
    steps_of_group_ *= 2;
  }
  return groups_.emplace_back(Vector::Zero(kVectors + 2 * dim_));
}

void RunLateness::add_to(LatenessSums& sums) const {
  if (steps_ == 0) return;
  Vector averages = Vector::Zero(kVectors + 2 * dim_);
  for (const Vector& group : groups_) averages += group;
  averages /= static_cast<double>(steps_);
  if (sums.runs.count > 0 && sums.runs.mean.size() != averages.size()) return;
  sums.runs.add(averages);
  const Slope slope = slope_of(averages);
  if (!(slope.varied > kLeastVaried * averages[kMotion])) return;
  sums.run_slopes.add(slope.steps());
  add_stretches(kLeastVariedStretch * slope.varied, sums);
}

void RunLateness::add_stretches(double least_varied, LatenessSums& sums) const {
  constexpr std::int64_t kStretches = 10, kFewestSteps = 5;
  const std::int64_t groups = steps_ / steps_of_group_ / kStretches;
  const std::int64_t steps = groups * steps_of_group_;
  if (steps < kFewestSteps) return;
  for (std::int64_t i = 0; i < kStretches; ++i) {
    Vector averages = Vector::Zero(kVectors + 2 * dim_);
    for (std::int64_t g = i * groups; g < (i + 1) * groups; ++g)
      averages += groups_[static_cast<std::size_t>(g)];
    const Slope slope = slope_of(averages / static_cast<double>(steps));
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
  const double steps = -across / varied;
  return {.runs = runs.count,
          .steps = steps,
          .p_value = student_upper_p_value(-across / std::sqrt(variance / n), n - 1.0),
          .explained = explained_by(steps, runs.mean)};
}

}  // namespace credence::internal
