#include "datasets/logs/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

using Points = std::vector<Eigen::Vector2d>;

Points random_points(unsigned seed, std::size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-20, 20);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = coordinate(random);
    points.emplace_back(x, coordinate(random));
  }
  return points;
}

Points moved(const Points& points, const Eigen::Isometry2d& motion) {
  Points result;
  for (const Eigen::Vector2d& point : points) result.push_back(motion * point);
  return result;
}

Eigen::Isometry2d motion_of(double angle, double x, double y) {
  return Eigen::Translation2d(x, y) * Eigen::Rotation2Dd(angle);
}

TEST(Alignment, RecoversARigidMotion) {
  const Points points = random_points(1, 9);
  for (const double angle : {0.0, 0.3, -2.9, 3.1415}) {
    const Eigen::Isometry2d motion = motion_of(angle, 3, -7);
    EXPECT_TRUE(align_rigidly(points, moved(points, motion)).isApprox(motion, 1e-12)) << angle;
    EXPECT_LT(rms_distance_aligned(points, moved(points, motion)), 1e-12);
  }
}

// The general solution by singular values ([Umeyama 1991], as in Eigen) on noisy points.
TEST(Alignment, AgreesWithTheGeneralSolution) {
  const Points from = random_points(2, 12);
  Points to = moved(from, motion_of(1.1, -4, 9));
  const Points noise = random_points(3, 12);
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += 0.1 * noise[i];
  Eigen::MatrixXd a(2, 12), b(2, 12);
  for (Index i = 0; i < 12; ++i) {
    a.col(i) = from[static_cast<std::size_t>(i)];
    b.col(i) = to[static_cast<std::size_t>(i)];
  }
  const Eigen::MatrixXd expected = Eigen::umeyama(a, b, false);
  EXPECT_LT((align_rigidly(from, to).matrix() - expected).norm(), 1e-12);
}

TEST(Alignment, DoesNotScaleOrMirror) {
  const Points square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Points twice = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  EXPECT_NEAR(rms_distance_aligned(square, twice), std::sqrt(0.5), 1e-12);
  const Points flipped = {{0, 0}, {1, 0}, {1, -3}, {0, -3}};
  EXPECT_GT(rms_distance_aligned({{0, 0}, {1, 0}, {1, 3}, {0, 3}}, flipped), 0.1);
}

TEST(Alignment, EdgeCases) {
  EXPECT_TRUE(align_rigidly({}, {}).isApprox(Eigen::Isometry2d::Identity()));
  EXPECT_EQ(rms_distance({}, {}), 0);
  EXPECT_DOUBLE_EQ(rms_distance_aligned({{1, 2}}, {{5, 5}}), 0);
  EXPECT_DOUBLE_EQ(rms_distance({{0, 0}, {0, 0}}, {{3, 4}, {0, 0}}), 5 / std::sqrt(2.0));
  EXPECT_THROW(rms_distance({{0, 0}}, {}), std::invalid_argument);
  EXPECT_THROW(align_rigidly({{0, 0}}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
