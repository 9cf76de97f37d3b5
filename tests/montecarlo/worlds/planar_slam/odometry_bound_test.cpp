#include "montecarlo/worlds/planar_slam/odometry_bound.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "core/models/range_bearing.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar_slam/odometry_simulation.h"
#include "tests/core/models/numerical_jacobian.h"

namespace credence::internal {
namespace {

Scenario bounded_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

OdometryWorld bounded_world(const std::vector<std::string>& overrides) {
  return make_odometry_world(bounded_scenario(overrides));
}

/// The bound without any recursion: x_0 and the noises of all controls so far are the unknowns of the path,
/// with the information that their covariances say; the landmarks are unknowns of which nothing is said.
/// Every observation adds p Hᵀ R⁻¹ H, by differences of the models. Its inverse, taken to pose and map.
class BoundInOneBatch {
 public:
  explicit BoundInOneBatch(const OdometryWorld& world) : world_(world) {
    const Index steps = std::ssize(world.plane.controls);
    path_ = 3 + 2 * steps;
    unknowns_ = path_ + 2 * std::ssize(world.plane.landmarks);
    information_ = Matrix::Zero(unknowns_, unknowns_);
    pose_ = Matrix::Zero(3, unknowns_);
    pose_.leftCols(3).setIdentity();
    information_.topLeftCorner(3, 3) = world.noise.initial_covariance().inverse();
    for (Index i = 3; i < path_; ++i) {
      const double std = world.noise.control_std[(i - 3) % 2];
      information_(i, i) = 1.0 / (std * std);
    }
  }

  /// Takes step k and gives the sums of variances of position, heading, and of all landmarks a landmark.
  std::array<double, 3> step(std::size_t k) {
    const PlanarTruth truth = world_.truth(k);
    const Control u = world_.plane.controls[k - 1];
    const auto by_pose = [&](const Vector& x) {
      return world_.plane.vehicle.moved(Pose(x), u, world_.plane.dt_s);
    };
    const auto by_control = [&](const Vector& v) {
      return world_.plane.vehicle.moved(truth.before, Control(v), world_.plane.dt_s);
    };
    pose_ = (numerical_jacobian(by_pose, truth.before) * pose_).eval();
    pose_.middleCols(3 + 2 * static_cast<Index>(k - 1), 2) += numerical_jacobian(by_control, u);
    for (const auto& seen : world_.in_view[k]) observe(seen.landmark, truth.now);
    // Landmarks not seen yet have no information: they are left out.
    std::vector<Index> known;
    for (Index i = 0; i < unknowns_; ++i) {
      if (information_(i, i) > 0.0) known.push_back(i);
    }
    const Matrix covariance = Matrix(information_(known, known)).inverse();
    const Matrix rows = pose_(Eigen::all, known);
    const Matrix of_pose = rows * covariance * rows.transpose();
    const auto landmarks = static_cast<Index>(known.size()) - path_;
    const bool all = landmarks == unknowns_ - path_;
    return {of_pose(0, 0) + of_pose(1, 1), of_pose(2, 2),
            all ? 2.0 * covariance.diagonal().tail(landmarks).sum() / static_cast<double>(landmarks)
                : std::nan("")};
  }

 private:
  void observe(int landmark, const Pose& pose) {
    const Point at = world_.plane.landmarks[static_cast<std::size_t>(landmark)];
    const auto by_pose = [&](const Vector& x) { return measured(Pose(x), at); };
    const auto by_landmark = [&](const Vector& l) { return measured(pose, Point(l)); };
    Matrix H = numerical_jacobian(by_pose, pose) * pose_;
    H.middleCols(path_ + 2 * Index{landmark}, 2) += numerical_jacobian(by_landmark, at);
    for (Index row = 0; row < 2; ++row) {
      const double std = world_.noise.measurement_std[row];
      information_ += world_.noise.detection_probability / (std * std) * H.row(row).transpose() * H.row(row);
    }
  }
  Eigen::Vector2d measured(const Pose& pose, const Point& at) const {
    if (world_.sensor.kind == LandmarkSensorKind::range_bearing) return measure_range_bearing(pose, at);
    const double c = std::cos(pose[2]), s = std::sin(pose[2]);
    const Point d = at - pose.head<2>();
    return {c * d[0] + s * d[1], -s * d[0] + c * d[1]};
  }

  const OdometryWorld& world_;
  Index path_, unknowns_;
  Matrix information_, pose_;
};

void expect_batch(const std::vector<std::string>& overrides) {
  const OdometryWorld world = bounded_world(overrides);
  const PosteriorBound bound = odometry_bound(world);
  ASSERT_EQ(bound.reason, "");
  BoundInOneBatch batch(world);
  int with_map = 0;
  for (std::size_t k = 1; k <= world.plane.controls.size(); ++k) {
    const auto [position, heading, map] = batch.step(k);
    EXPECT_NEAR(bound.find("position")->bound[k - 1], position, 1e-7 * position) << k;
    EXPECT_NEAR(bound.find("heading")->bound[k - 1], heading, 1e-7 * heading) << k;
    const double all = bound.find("all landmarks")->bound[k - 1];
    EXPECT_EQ(std::isnan(all), std::isnan(map)) << k;
    if (std::isnan(map)) continue;
    ++with_map;
    EXPECT_NEAR(all, map, 1e-7 * map) << k;
  }
  EXPECT_GT(with_map, 0);
}

// At one truth, where all means are the Jacobians themselves.
TEST(OdometryBound, IsThatOfAllNoisesAndLandmarksInOneBatch) {
  expect_batch({"study.steps=25", "world.landmarks=5", "world.sensor_range=100"});
}

TEST(OdometryBound, OfRangeAndBearingMissedNowAndThen) {
  expect_batch({"study.steps=25", "world.landmarks=4", "world.landmark_sensor=range_bearing",
                "world.sensor_range=100", "noise.detection_probability=0.6"});
}

TEST(OdometryBound, OfAMapThatComesIntoViewOneByOne) {
  expect_batch({"study.steps=60", "world.landmarks=6", "world.path_radius=3", "world.sensor_range=4"});
}

// Where the heading is known the world is linear, and its bound is the Kalman filter's P. Observations that
// are missed half the time tell half as much.
TEST(OdometryBound, IsTheKalmanFilterOfALinearWorld) {
  const std::vector<std::string> known = {"initial.heading_std_deg=0", "noise.turn_rate_std=0",
                                          "study.steps=200"};
  const Scenario s = bounded_scenario(known);
  const OdometryWorld world = make_odometry_world(s);
  const PosteriorBound bound = odometry_bound(world);
  EXPECT_EQ(bound.find("heading")->mean_bound(), 0.0);
  const double position = bound.find("position")->mean_bound();
  const auto filter = scenario_estimator(s, world);
  OdometrySimulation simulation(world, NoiseSource(1, 2));
  filter->reset(simulation.start(0), world.noise.initial_covariance());
  double variance = 0.0;
  for (std::size_t k = 1; k <= 200; ++k) {
    filter->predict(simulation.read(k), world.truth(k));
    filter->update(simulation.observe(k), world.truth(k));
    variance += filter->covariance().diagonal().head<2>().sum() / 200.0;
  }
  EXPECT_NEAR(position, variance, 1e-10 * variance);
  std::vector<std::string> missed = known;
  missed.emplace_back("noise.detection_probability=0.5");
  std::vector<std::string> noisier = known;
  noisier.push_back(fmt::format("noise.relative_position_std={:.17g}", 0.1 * std::sqrt(2.0)));
  const auto position_of = [](const std::vector<std::string>& overrides) {
    return odometry_bound(make_odometry_world(bounded_scenario(overrides))).find("position")->mean_bound();
  };
  const double half = position_of(missed);
  EXPECT_GT(half, 1.05 * position);
  EXPECT_NEAR(half, position_of(noisier), 1e-10 * half);
}

}  // namespace
}  // namespace credence::internal
