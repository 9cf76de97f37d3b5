#include "datasets/logs/alignment.h"

#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

void check_lengths(std::size_t a, std::size_t b) {
  if (a != b) throw std::invalid_argument("two lists of points must have the same length");
}

Eigen::Vector2d mean(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

Eigen::Isometry2d align_rigidly(const std::vector<Eigen::Vector2d>& from,
                                const std::vector<Eigen::Vector2d>& to) {
  check_lengths(from.size(), to.size());
  if (from.empty()) return Eigen::Isometry2d::Identity();
  const Eigen::Vector2d center_from = mean(from), center_to = mean(to);
  // In the plane the singular value decomposition of the general solution is one angle.
  double dot = 0, cross = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d a = from[i] - center_from, b = to[i] - center_to;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
  }
  Eigen::Isometry2d motion = Eigen::Isometry2d::Identity();
  motion.linear() = Eigen::Rotation2Dd(std::atan2(cross, dot)).toRotationMatrix();
  motion.translation() = center_to - motion.linear() * center_from;
  return motion;
}

double rms_distance(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  check_lengths(a.size(), b.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return a.empty() ? 0 : std::sqrt(sum / static_cast<double>(a.size()));
}

double rms_distance_aligned(const std::vector<Eigen::Vector2d>& truth,
                            const std::vector<Eigen::Vector2d>& estimate) {
  const Eigen::Isometry2d motion = align_rigidly(truth, estimate);
  std::vector<Eigen::Vector2d> moved;
  moved.reserve(truth.size());
  for (const Eigen::Vector2d& point : truth) moved.push_back(motion * point);
  return rms_distance(moved, estimate);
}

}  // namespace credence::internal
