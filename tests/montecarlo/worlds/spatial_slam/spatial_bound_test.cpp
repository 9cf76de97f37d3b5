#include "montecarlo/worlds/spatial_slam/spatial_bound.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "tests/core/models/numerical_jacobian.h"

namespace credence::internal {
namespace {

SpatialWorld bounded_space(const std::vector<std::string>& overrides) {
  return make_spatial_world(load_scenario_text("[world]\nmodel = \"spatial_slam\"\n", "t.toml", overrides));
}

/// The pose of step k from all that moves it: y = (δp, φ of the start; noise on v, ω of every step;
/// landmarks).
SE3 pose_of(const SpatialWorld& world, std::size_t k, const Vector& y) {
  const SE3& start = world.path.front();
  SO3 R = SO3::Exp(y.segment<3>(3)) * start.rotation();
  Eigen::Vector3d p = start.translation() + y.head<3>();
  for (std::size_t j = 0; j < k; ++j) {
    const auto at = static_cast<Index>(6 + 6 * j);
    const SpatialControl& u = world.controls[j];
    p = (p + R.matrix() * (u.v + y.segment<3>(at))).eval();
    R = R * SO3::Exp(u.omega + y.segment<3>(at + 3));
  }
  return {R, p};
}

/// The bound at step k without any recursion: the information of the start, of all noises and of all
/// observations so far, inverted, and taken to the pose; all Jacobians by differences. Position, attitude.
std::pair<double, double> bound_in_one_batch(const SpatialWorld& world, std::size_t k) {
  const auto path = static_cast<Index>(6 + 6 * k);
  const Index landmarks = std::ssize(world.landmarks);
  Vector truth = Vector::Zero(path + 3 * landmarks);
  for (Index i = 0; i < landmarks; ++i) {
    truth.segment<3>(path + 3 * i) = world.landmarks[static_cast<std::size_t>(i)];
  }
  Matrix information = Matrix::Zero(truth.size(), truth.size());
  information.diagonal().head<6>() = world.initial_std.cwiseAbs2().cwiseInverse();
  for (std::size_t j = 0; j < k; ++j) {
    information.diagonal().segment<6>(static_cast<Index>(6 + 6 * j)) =
        world.controls[j].variances.cwiseInverse();
  }
  for (std::size_t j = 1; j <= k; ++j) {
    for (const SpatialWorld::Exact& exact : world.in_view[j]) {
      const auto measured = [&](const Vector& y) {
        const SE3 pose = pose_of(world, j, y);
        const Eigen::Vector3d l = y.segment<3>(path + 3 * Index{exact.landmark});
        return Eigen::Vector3d(pose.rotation().matrix().transpose() * (l - pose.translation()));
      };
      const Matrix H = numerical_jacobian(measured, truth);
      const Eigen::Vector3d variances = world.landmark_variances(exact.z);
      information += world.detection_probability * H.transpose() * variances.cwiseInverse().asDiagonal() * H;
    }
  }
  const SE3 pose = pose_of(world, k, truth);
  const auto error = [&](const Vector& y) {
    const SE3 moved = pose_of(world, k, y);
    Vector e(6);
    e << moved.translation() - pose.translation(), (moved.rotation() * pose.rotation().inverse()).Log();
    return e;
  };
  const Matrix J = numerical_jacobian(error, truth);
  std::vector<Index> known;  // nothing is known of a landmark that was never seen
  for (Index i = 0; i < truth.size(); ++i) {
    if (information(i, i) > 0.0) known.push_back(i);
  }
  const Matrix rows = J(Eigen::all, known);
  const Matrix P = rows * Matrix(information(known, known)).inverse() * rows.transpose();
  return {P.topLeftCorner(3, 3).trace(), P.bottomRightCorner(3, 3).trace()};
}

TEST(SpatialBound, IsThatOfAllNoisesAndLandmarksInOneBatch) {
  for (const char* detection : {"1", "0.5"}) {
    const SpatialWorld world =
        bounded_space({"study.steps=6", "world.loop_steps=20", "world.landmarks=4", "world.sensor_range=60",
                       "initial.position_std=0.2", "initial.heading_std_deg=3",
                       std::string("noise.detection_probability=") + detection});
    std::size_t seen = 0;
    for (const auto& step : world.in_view) seen += step.size();
    ASSERT_GT(seen, 3U);
    const PosteriorBound bound = spatial_bound(world);
    for (const std::size_t k : {1U, 3U, 6U}) {
      const auto [position, attitude] = bound_in_one_batch(world, k);
      EXPECT_NEAR(bound.find("position")->bound[k - 1], position, 1e-6 * position) << k << detection;
      EXPECT_NEAR(bound.find("attitude")->bound[k - 1], attitude, 1e-6 * attitude) << k << detection;
    }
  }
}

TEST(SpatialBound, OfAFilterThatBelievesOtherNoiseIsTheSame) {
  const std::vector<std::string> plain = {"study.steps=10"};
  const auto mean = [](const std::vector<std::string>& overrides) {
    return spatial_bound(bounded_space(overrides)).find("position")->mean_bound();
  };
  EXPECT_EQ(mean(plain), mean({"study.steps=10", "filter.process_scale=5", "filter.measurement_scale=0.1"}));
  EXPECT_LT(mean(plain), mean({"study.steps=10", "noise.detection_probability=0.2"}));
}

}  // namespace
}  // namespace credence::internal
