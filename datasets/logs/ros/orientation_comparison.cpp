#include "datasets/logs/ros/orientation_comparison.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace credence {

void OrientationComparison::add(const PoseEstimate& estimate, const UncertainPose& truth,
                                std::span<const Index> kept) {
  if (kept.size() != 6) return;
  const PoseCovariance P = estimate.covariance + truth.covariance;
  const Eigen::LLT<PoseCovariance> factor(P);
  if (factor.info() != Eigen::Success) return;
  std::array<double, kKinds.size()> nees{};
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    const auto error = pose_error(estimate.pose, truth.pose, {.orientation = kKinds[i]});
    nees[i] = factor.matrixL().solve(error).squaredNorm();
    if (!std::isfinite(nees[i])) return;
  }
  for (std::size_t i = 0; i < nees.size(); ++i) sums_[i] += nees[i];
  ++count_;
}

std::string OrientationComparison::remark(OrientationError judged) const {
  constexpr double kDiffer = 1.1;
  if (count_ == 0) return "";
  const auto [least, most] = std::ranges::minmax(sums_);
  if (!(most > kDiffer * least)) return "";
  std::string text;
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    text += fmt::format("{}{} {:.4g}", text.empty() ? "" : ", ", to_string(kKinds[i]),
                        sums_[i] / static_cast<double>(count_));
  }
  return fmt::format(
      "What the orientation's covariance speaks of matters here; mean NEES of the pose (6 expected): {}. "
      "Judged is {} (--orientation-error).",
      text, to_string(judged));
}

std::string_view to_string(OrientationError kind) {
  switch (kind) {
    case OrientationError::body:
      return "body";
    case OrientationError::world:
      return "world";
    case OrientationError::rpy:
      return "rpy";
    case OrientationError::planar:
      return "planar";
  }
  return "unknown";
}

}  // namespace credence
