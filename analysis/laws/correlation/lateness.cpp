#include "analysis/laws/correlation/lateness.h"

#include <cmath>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// Places in the averages of a run.
constexpr Index kAcross = 0, kMotion = 1, kError = 2, kVectors = 3;

LatenessTest no_lateness(std::int64_t runs, std::string_view reason) {
  return {.runs = runs, .steps = kNaN, .p_value = kNaN, .explained = kNaN, .reason = reason};
}

}  // namespace

void RunLateness::add(const Vector& u, const Vector& b) {
  if (!u.allFinite() || !b.allFinite()) return;
  if (steps_ == 0) u_ = b_ = Vector::Zero(u.size());
  if (u.size() != u_.size()) return;
  ++steps_;
  across_ += b.dot(u);
  motion_ += b.squaredNorm();
  error_ += u.squaredNorm();
  u_ += u;
  b_ += b;
}

void RunLateness::add_to(VectorMoments& runs) const {
  if (steps_ == 0) return;
  Vector averages(kVectors + 2 * u_.size());
  averages << across_, motion_, error_, u_, b_;
  if (runs.count > 0 && runs.mean.size() != averages.size()) return;
  runs.add(averages / static_cast<double>(steps_));
}

void merge_lateness(const VectorMoments& later, VectorMoments& runs) {
  if (runs.count == 0 || later.count == 0 || runs.mean.size() == later.mean.size()) runs.merge(later);
}

LatenessTest test_lateness(const VectorMoments& runs) {
  constexpr std::int64_t kFewest = 10;
  constexpr double kLeastVaried = 0.1;
  if (runs.count < kFewest) return no_lateness(runs.count, "fewer than ten runs");
  if (!runs.mean.allFinite() || !runs.scatter.allFinite()) {
    return no_lateness(runs.count, "a value is not finite");
  }
  const Index dim = (runs.mean.size() - kVectors) / 2;
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
  const double excess = runs.mean[kError] - static_cast<double>(dim);
  // |u|² − |u + d b|², with the motion as it is.
  const double less = -2.0 * steps * runs.mean[kAcross] - steps * steps * runs.mean[kMotion];
  return {.runs = runs.count,
          .steps = steps,
          .p_value = student_upper_p_value(-across / std::sqrt(variance / n), n - 1.0),
          .explained = excess > 0.0 ? less / excess : 0.0};
}

}  // namespace credence::internal
