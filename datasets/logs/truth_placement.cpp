#include "datasets/logs/truth_placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/append_item.h"
#include "core/linear_algebra/psd_root.h"
#include "core/manifold/sek3.h"
#include "datasets/logs/conventions/thinned.h"

namespace credence::internal {
namespace {

/// The directions (position, rotation) in which the frame is free.
std::vector<Index> free_directions(TruthAlignment alignment) {
  switch (alignment) {
    case TruthAlignment::none: break;
    case TruthAlignment::se2: return {0, 1, 5};
    case TruthAlignment::yaw: return {0, 1, 2, 5};
    case TruthAlignment::se3: return {0, 1, 2, 3, 4, 5};
  }
  return {};
}

/// A⁻¹ on the directions in which A is not singular.
Matrix inverse_where_regular(const Matrix& A) {
  const Matrix W = psd_whitening(A);
  return W.transpose() * W;
}

/// A sample and its P⁻¹, on what it gives a variance.
struct WeightedRow {
  EstimateSample sample;
  Matrix weight;
};

/// One row under one motion.
struct RowFit {
  Vector error;
  Matrix J;             ///< by the free directions
  Index positions = 0;  ///< components that are positions, which come first
  Matrix information;   ///< Jᵀ W J
};

class PlacementFit {
 public:
  PlacementFit(std::span<const EstimateSample> samples, const Trajectory& truth,
               const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance,
               std::size_t stride)
      : truth_(truth),
        matching_(matching),
        axes_(axes),
        joint_covariance_(joint_covariance),
        free_(free_directions(matching.alignment)) {
    weigh(samples, stride);
  }

  const std::vector<WeightedRow>& rows() const { return rows_; }
  const Eigen::Vector3d& centre() const { return centre_; }
  const std::vector<Index>& free() const { return free_; }

  /// Every row under a motion.
  template <class Take>
  void each(std::span<const WeightedRow> rows, const Eigen::Isometry3d& motion, Take take) const {
    TruthPlacement placement;
    placement.motion = motion;
    const TruthComparison comparison(truth_, matching_, axes_, joint_covariance_, placement);
    Step step;
    for (const WeightedRow& row : rows) {
      const UncertainPose at = *comparison.truth_at(row.sample.estimate.time_s);
      comparison.compare(row.sample.estimate, at, row.sample.kept, step);
      const Matrix J = comparison.frame_jacobian(row.sample.estimate, at, step, centre_)(Eigen::all, free_);
      const auto positions =
          std::ranges::count_if(step.states, [&](Index state) { return state < positions_; });
      take(row, RowFit{step.error, J, positions, J.transpose() * row.weight * J});
    }
  }

  /// The least sum from `motion` on.
  Eigen::Isometry3d least(std::span<const WeightedRow> rows, Eigen::Isometry3d motion) const {
    constexpr int kSteps = 50, kHalvings = 12;
    constexpr double kDone = 1e-24;  // of the sum
    Matrix A;
    Vector b;
    double sum = normal_equations(rows, motion, A, b);
    for (int i = 0; i < kSteps; ++i) {
      Vector step = -(inverse_where_regular(A) * b);
      const double expected = -b.dot(step);
      bool fell = false;
      for (int h = 0; h < kHalvings && !fell; ++h, step *= 0.5) {
        const Eigen::Isometry3d next = moved(motion, step);
        Matrix next_A;
        Vector next_b;
        const double next_sum = normal_equations(rows, next, next_A, next_b);
        if (!(next_sum < sum)) continue;
        fell = true;
        motion = next;
        sum = next_sum;
        A = next_A;
        b = next_b;
      }
      if (!fell || !(expected > kDone * sum)) break;
    }
    return motion;
  }

  /// By the headings or orientations of the first row that has one, then by all positions.
  Eigen::Isometry3d start() const {
    std::vector<SpatialPose> true_poses, estimates;
    for (const WeightedRow& row : rows_) {
      true_poses.push_back(truth_at(truth_, row.sample.estimate.time_s, matching_)->pose);
      estimates.push_back(row.sample.estimate.pose);
    }
    if (!truth_.has_orientation) return align_truth(true_poses, estimates, matching_.alignment);
    Eigen::Quaterniond turn = estimates[0].orientation * true_poses[0].orientation.conjugate();
    if (matching_.alignment != TruthAlignment::se3) {
      const Eigen::Matrix3d R = turn.toRotationMatrix();
      turn = Eigen::AngleAxisd(std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)), Eigen::Vector3d::UnitZ());
    }
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < true_poses.size(); ++i) {
      shift +=
          (estimates[i].position - turn * true_poses[i].position) / static_cast<double>(true_poses.size());
    }
    if (matching_.alignment == TruthAlignment::se2) shift.z() = 0.0;
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = turn.toRotationMatrix();
    motion.translation() = shift;
    return motion;
  }

 private:
  void weigh(std::span<const EstimateSample> samples, std::size_t stride) {
    constexpr double kRounding = 1e-9;  // of the mean P, so that a P of zero weighs much and not everything
    const TruthComparison comparison(truth_, matching_, axes_, joint_covariance_);
    positions_ = axes_.orientation == OrientationError::planar ? 2 : 3;
    std::vector<Step> steps;
    Vector sum = Vector::Zero(std::ssize(comparison.layout().states));  // of the variances
    for (std::size_t i = 0; i < samples.size(); i += stride) {
      const auto at = comparison.truth_at(samples[i].estimate.time_s);
      Step step;
      if (!at || !comparison.compare(samples[i].estimate, *at, samples[i].kept, step)) continue;
      sum(step.states) += step.P.diagonal();
      centre_ += samples[i].estimate.pose.position;
      rows_.push_back({samples[i], {}});
      steps.push_back(std::move(step));
    }
    if (rows_.empty()) return;
    const double count = static_cast<double>(rows_.size());
    centre_ /= count;
    std::vector<WeightedRow> kept;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      Matrix P = steps[i].P;
      P.diagonal() += kRounding / count * sum(steps[i].states);
      if (!(P.diagonal().maxCoeff() > 0.0)) continue;
      rows_[i].weight = inverse_where_regular(P);
      kept.push_back(std::move(rows_[i]));
    }
    rows_ = std::move(kept);
  }

  double normal_equations(std::span<const WeightedRow> rows, const Eigen::Isometry3d& motion, Matrix& A,
                          Vector& b) const {
    double sum = 0.0;
    A = Matrix::Zero(std::ssize(free_), std::ssize(free_));
    b = Vector::Zero(std::ssize(free_));
    each(rows, motion, [&](const WeightedRow& row, const RowFit& fit) {
      const Vector weighted = row.weight * fit.error;
      A += fit.information;
      b += fit.J.transpose() * weighted;
      sum += weighted.dot(fit.error);
    });
    return sum;
  }

  /// Exp(w) about the centre, after the motion.
  Eigen::Isometry3d moved(const Eigen::Isometry3d& motion, const Vector& step) const {
    SE3::Tangent w = SE3::Tangent::Zero();
    w(free_) = step;
    const SE3 by = SE3::Exp(w);
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = by.rotation().matrix();
    turn.translation() = by.translation();
    return Eigen::Translation3d(centre_) * turn * Eigen::Translation3d(-centre_) * motion;
  }

  const Trajectory& truth_;
  TrajectoryMatching matching_;
  PoseErrorAxes axes_;
  bool joint_covariance_;
  std::vector<Index> free_;
  Index positions_ = 0;  ///< states that are positions
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::vector<WeightedRow> rows_;
};

/// The row whose error moves the positions of all least.
std::optional<std::size_t> best_anchor(const PlacementFit& fit, const Eigen::Isometry3d& motion,
                                       Matrix& covariance) {
  constexpr double kDetermined = 1e-9;
  Matrix spread = Matrix::Zero(std::ssize(fit.free()), std::ssize(fit.free()));
  std::vector<Matrix> information;
  fit.each(fit.rows(), motion, [&](const WeightedRow&, const RowFit& row) {
    const auto of_positions = row.J.topRows(row.positions);
    spread += of_positions.transpose() * of_positions;
    information.push_back(row.information);
  });
  std::optional<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < information.size(); ++i) {
    const Matrix W = psd_whitening(information[i], kDetermined);
    if (W.rows() < W.cols()) continue;
    const Matrix C = W.transpose() * W;
    const double moves = (C * spread).trace();
    if (!(moves < least)) continue;
    least = moves;
    best = i;
    covariance = C;
  }
  return best;
}

}  // namespace

bool is_fitted(const TrajectoryMatching& matching) {
  return matching.find_time_offset != TimeOffsetSearch::none || matching.alignment != TruthAlignment::none;
}

std::vector<EstimateSample> pose_samples(const Trajectory& estimate, const TrajectoryMatching& matching) {
  if (!is_fitted(matching)) return {};
  std::vector<EstimateSample> samples;
  std::size_t stride = 1, seen = 0;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    if (!keep_thinned(samples, stride, seen)) continue;
    samples.push_back({{estimate.time_s[i], estimate.lines[i], estimate.poses[i], estimate.covariances[i]},
                       {0, 1, 2, 3, 4, 5}});
  }
  return samples;
}

Eigen::Isometry3d fitted_motion(std::span<const EstimateSample> samples, const Trajectory& truth,
                                const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance,
                                std::size_t stride) {
  if (matching.alignment == TruthAlignment::none) return Eigen::Isometry3d::Identity();
  const PlacementFit fit(samples, truth, matching, axes, joint_covariance, stride);
  return fit.rows().empty() ? Eigen::Isometry3d::Identity() : fit.least(fit.rows(), fit.start());
}

TruthPlacement place_truth(std::span<const EstimateSample> samples, const Trajectory& truth,
                           const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance) {
  TruthPlacement placement{.alignment = matching.alignment};
  if (matching.alignment == TruthAlignment::none) return placement;
  const PlacementFit fit(samples, truth, matching, axes, joint_covariance, 1);
  placement.by_all = true;
  if (fit.rows().empty()) return placement;
  placement.motion = fit.least(fit.rows(), fit.start());
  Matrix C;
  const std::optional<std::size_t> anchor = best_anchor(fit, placement.motion, C);
  if (!anchor) return placement;

  const std::span row(&fit.rows()[*anchor], 1);
  TruthPlacement by_one{.alignment = matching.alignment,
                        .motion = fit.least(row, placement.motion),
                        .time_s = row[0].sample.estimate.time_s,
                        .centre = fit.centre()};
  by_one.covariance(fit.free(), fit.free()) = C;
  const TruthComparison comparison(truth, matching, axes, joint_covariance, by_one);
  std::size_t known = 0;
  Step step;
  for (const auto& [sample, weight] : fit.rows()) {
    const UncertainPose at = *comparison.truth_at(sample.estimate.time_s);
    comparison.compare(sample.estimate, at, sample.kept, step);
    known += comparison.used_up(sample.estimate, at, step) ? 0 : 1;
  }
  return 2 * known >= fit.rows().size() ? by_one : placement;
}

void tell_placement(const TruthPlacement& placement, std::int64_t used_up, LogSink& sink) {
  if (placement.alignment == TruthAlignment::none) return;
  if (!placement.by_all) {
    sink.remark(fmt::format(
        "The truth was placed (--align {}) by the pose that knows its frame best. What that leaves "
        "open is at most {:g} % of P in every direction; {} of which it is more {} left out.",
        to_string(placement.alignment), 100.0 * TruthPlacement::kKnown, counted(used_up, "row"),
        used_up == 1 ? "was" : "were"));
    return;
  }
  sink.truth_fit(TruthFit::least_nees);
  sink.remark(fmt::format(
      "The truth was placed (--align {}) by the errors of all rows, as no pose knows its frame so well that "
      "it could hold it for the others. That makes errors smaller, by an unknown part where they are "
      "correlated: the word is optimistic only where the mean NEES is too large wherever the truth lies, and "
      "never pessimistic.",
      to_string(placement.alignment)));
}

}  // namespace credence::internal
