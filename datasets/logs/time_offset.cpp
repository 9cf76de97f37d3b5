#include "datasets/logs/time_offset.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student.h"
#include "datasets/logs/truth_placement.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr double kFarthest_s = 1.0;

/// e_k(τ) of the samples; nothing for those without a truth at their time.
class OffsetErrors {
 public:
  OffsetErrors(std::span<const EstimateSample> samples, const Trajectory& truth,
               const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance)
      : samples_(samples),
        truth_(truth),
        matching_(matching),
        axes_(axes),
        joint_covariance_(joint_covariance) {
    each(0.0, 1, [this](std::size_t i, const Step& step) {
      const Eigen::LLT<Matrix> factor(step.P);
      if (factor.info() != Eigen::Success) return;
      weights_[i] = factor.solve(Matrix::Identity(step.P.rows(), step.P.cols()));
    });
  }

  /// Mean of eᵀ P⁻¹ e over every `stride`-th sample; infinite where fewer than half of them have a truth.
  double cost(double tau, std::size_t stride) {
    Moments mean;
    each(tau, stride, [&](std::size_t i, const Step& step) {
      if (weights_[i].rows() == step.error.size()) mean.add(step.error.dot(weights_[i] * step.error));
    });
    const auto asked = static_cast<std::int64_t>(samples_.size() / stride);
    return 2 * mean.count >= asked && mean.count > 0 ? mean.mean : std::numeric_limits<double>::infinity();
  }

  std::vector<std::optional<Vector>> errors(double tau) {
    std::vector<std::optional<Vector>> all(samples_.size());
    each(tau, 1, [&](std::size_t i, const Step& step) { all[i] = step.error; });
    return all;
  }

  const Matrix& weight(std::size_t i) const { return weights_[i]; }

 private:
  template <class Take>
  void each(double tau, std::size_t stride, Take take) {
    weights_.resize(samples_.size());
    TrajectoryMatching shifted = matching_;
    shifted.time_offset_s = tau;
    shifted.truth_time = TruthTime::interpolated;  // e(τ) jumps between nearest ones, and stands still
    TruthPlacement placement;
    placement.motion = fitted_motion(samples_, truth_, shifted, axes_, joint_covariance_, stride);
    const TruthComparison comparison(truth_, shifted, axes_, joint_covariance_, placement);
    Step step;
    for (std::size_t i = 0; i < samples_.size(); i += stride) {
      const EstimateSample& sample = samples_[i];
      const std::optional<UncertainPose> at = comparison.truth_at(sample.estimate.time_s);
      if (at && comparison.compare(sample.estimate, *at, sample.kept, step)) take(i, step);
    }
  }

  std::span<const EstimateSample> samples_;
  const Trajectory& truth_;
  TrajectoryMatching matching_;
  PoseErrorAxes axes_;
  bool joint_covariance_;
  std::vector<Matrix> weights_;  ///< P⁻¹ at τ = 0; empty where there is none
};

/// Where the cost is least, on a grid and then between its points; NaN at the ends of the range.
double least_cost(OffsetErrors& errors, std::size_t samples) {
  constexpr int kGrid = 50;  // points on each side
  constexpr std::size_t kOnGrid = 256;
  constexpr double kStep = kFarthest_s / kGrid;
  const std::size_t stride = std::max<std::size_t>(1, samples / kOnGrid);
  int best = -kGrid;
  double least = std::numeric_limits<double>::infinity();
  for (int i = -kGrid; i <= kGrid; ++i) {
    if (const double cost = errors.cost(i * kStep, stride); cost < least) {
      least = cost;
      best = i;
    }
  }
  if (std::abs(best) == kGrid) return kNaN;
  constexpr int kBits = 24;
  return boost::math::tools::brent_find_minima([&](double tau) { return errors.cost(tau, 1); },
                                               (best - 1) * kStep, (best + 1) * kStep, kBits)
      .first;
}

/// Why no time can be found in a truth of these times: most moments between two of them have one within the
/// limit on one side alone, so that nothing is compared there. "" where there is no such reason.
std::string too_coarse(const Trajectory& truth, double limit_s) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < truth.time_s.size(); ++i) gaps.push_back(truth.time_s[i] - truth.time_s[i - 1]);
  if (gaps.empty()) return "the truth has one row";
  const auto middle = gaps.begin() + std::ssize(gaps) / 2;
  std::ranges::nth_element(gaps, middle);
  // Of a gap g the moments with both ends within the limit L are 2 L − g; half of it, as cost() asks for.
  if (*middle <= 4.0 / 3.0 * limit_s) return "";
  constexpr double kRoom = 1.5;
  return fmt::format(
      "the truth has a row every {:.3g} s, of which one before and one behind an estimate must be within "
      "--max-time-difference {:g} s; with --max-time-difference {:.2g} the truth is interpolated between "
      "them",
      *middle, limit_s, kRoom * *middle);
}

/// q_k of the rows in order, whose mean is zero at τ̂; empty where nothing moves.
std::vector<double> influences(OffsetErrors& errors, double tau) {
  constexpr double kDifference_s = 0.01;
  const auto at = errors.errors(tau), before = errors.errors(tau - kDifference_s),
             behind = errors.errors(tau + kDifference_s);
  std::vector<double> q;
  double information = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!at[i] || !before[i] || !behind[i] || errors.weight(i).rows() != at[i]->size() ||
        before[i]->size() != at[i]->size() || behind[i]->size() != at[i]->size()) {
      continue;
    }
    const Vector v = (*before[i] - *behind[i]) / (2.0 * kDifference_s);
    const Vector weighted = errors.weight(i) * v;
    q.push_back(weighted.dot(*at[i]));
    information += weighted.dot(v);
  }
  if (!(information > 0.0)) return {};
  for (double& value : q) value *= static_cast<double>(q.size()) / information;
  return q;
}

/// A sentence for the report.
std::string time_offset_text(const TimeOffset& offset) {
  const auto order = [](double value_s) { return value_s > 0.0 ? "behind" : "ahead of"; };
  if (!offset.estimated) {
    return fmt::format(
        "The estimate's times were taken to be {:.6g} s {} those of the truth (--time-offset).",
        std::abs(offset.value_s), order(offset.value_s));
  }
  if (std::isnan(offset.value_s)) {
    return fmt::format(
        "No time offset was used, as none could be estimated: {}. When the truth was is not "
        "known, so that no errors are evidence.",
        offset.reason);
  }
  if (!offset.reason.empty()) {
    return fmt::format(
        "The time offset of the least mean NEES was used: the estimate's times are {:.4g} s {} those of the "
        "truth. It has no interval, as {}. That makes errors smaller by an unknown part: the word is "
        "optimistic only where the mean NEES is too large at every time within {:g} s, and never "
        "pessimistic.",
        std::abs(offset.value_s), order(offset.value_s), offset.reason, kFarthest_s);
  }
  const bool none = offset.lower_s <= 0.0 && offset.upper_s >= 0.0;
  return fmt::format(
      "The time offset was estimated from these errors, and used: the estimate's times are {:.4g} s {} those "
      "of the "
      "truth ({:.4g} … {:.4g} at {:g} %, from stretches of {} rows){}. NEES is that of the best time, one "
      "dof of the whole log lower.",
      std::abs(offset.value_s), order(offset.value_s), offset.lower_s, offset.upper_s,
      100.0 * offset.confidence, offset.rows, none ? "; no offset at all fits as well" : "");
}

}  // namespace

TimeOffset find_time_offset(std::span<const EstimateSample> samples, const Trajectory& truth,
                            const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance,
                            double confidence) {
  constexpr std::size_t kStretches = 10;
  constexpr double kShortestStretch = 10.0;  // in correlation times
  TimeOffset offset{.confidence = confidence, .estimated = true};
  offset.reason = too_coarse(truth, matching.max_time_difference_s);
  if (!offset.reason.empty()) return offset;
  OffsetErrors errors(samples, truth, matching, axes, joint_covariance);
  offset.value_s = least_cost(errors, samples.size());
  if (std::isnan(offset.value_s)) {
    offset.reason = fmt::format("no time within {:g} s fits better than those beyond", kFarthest_s);
    return offset;
  }
  const std::vector<double> q = influences(errors, offset.value_s);
  offset.rows = std::ssize(q);
  const std::size_t length = q.size() / kStretches;
  if (length == 0) {
    offset.reason = q.empty() ? "nothing moves" : "too few rows";
    return offset;
  }
  const EffectiveSample sample = effective_sample(std::vector<std::span<const double>>{q}, 0.0);
  if (!sample.reason.empty()) {
    offset.reason = sample.reason;
    return offset;
  }
  if (static_cast<double>(length) < kShortestStretch * sample.correlation_time) {
    offset.reason = fmt::format(
        "the log is {:.3g} times as long as its errors are correlated, and {:g} times are asked for",
        static_cast<double>(q.size()) / sample.correlation_time,
        kShortestStretch * static_cast<double>(kStretches));
    return offset;
  }
  Moments stretches;
  for (std::size_t s = 0; s < kStretches; ++s) {
    double sum = 0.0;
    for (std::size_t i = 0; i < length; ++i) sum += q[s * length + i];
    stretches.add(sum / static_cast<double>(length));
  }
  const double half = student_interval(stretches, confidence).half_width();
  offset.lower_s = offset.value_s - half;
  offset.upper_s = offset.value_s + half;
  if (!(half < kFarthest_s)) offset.reason = "its interval is wider than the times that were tried";
  return offset;
}

TrajectoryMatching with_time_offset(std::span<const EstimateSample> samples, const Trajectory& truth,
                                    TrajectoryMatching matching, PoseErrorAxes axes, bool joint_covariance,
                                    LogSink& sink) {
  const double named_s = matching.time_offset_s.value_or(0.0);
  if (!matching.find_time_offset && named_s == 0.0) return matching;
  TimeOffset offset{.value_s = named_s, .rows = std::ssize(samples)};
  if (matching.find_time_offset) {
    offset = find_time_offset(samples, truth, matching, axes, joint_covariance);
    const bool found = !std::isnan(offset.value_s);
    matching.time_offset_s = found ? offset.value_s : 0.0;
    if (!offset.reason.empty()) sink.truth_fit(found ? TruthFit::least_nees : TruthFit::not_found);
  }
  sink.remark(time_offset_text(offset));
  sink.time_offset(std::move(offset));
  return matching;
}

}  // namespace credence::internal
