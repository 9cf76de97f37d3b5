#include "montecarlo/worlds/spatial_slam/spatial_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario spatial_scenario(std::vector<std::string> overrides) {
  return load_scenario_text("[world]\nmodel = \"spatial_slam\"\n", "t.toml", overrides);
}

TEST(SpatialWorld, PathIsAClosedEllipseThatRisesAndFallsTwice) {
  const SpatialWorld world =
      make_spatial_world(spatial_scenario({"world.path_length=40", "world.path_width=20",
                                           "world.path_height=6", "world.loop_steps=80", "study.steps=80"}));
  ASSERT_EQ(world.path.size(), 81U);
  EXPECT_LT((world.path.front().translation() - world.path.back().translation()).norm(), 1e-11);
  std::vector<double> heights;
  for (const SE3& pose : world.path) {
    const Eigen::Vector3d p = pose.translation();
    EXPECT_NEAR(p[0] * p[0] / 400.0 + p[1] * p[1] / 100.0, 1.0, 1e-12);
    heights.push_back(p[2]);
  }
  EXPECT_NEAR(*std::ranges::max_element(heights), 3.0, 1e-12);
  int crossings = 0;
  for (std::size_t k = 1; k < heights.size(); ++k) crossings += heights[k - 1] * heights[k] < -1e-20;
  EXPECT_GE(crossings, 2);
}

TEST(SpatialWorld, LooksAlongItsPathAndStandsLevel) {
  const SpatialWorld world =
      make_spatial_world(spatial_scenario({"world.loop_steps=2000", "study.steps=2000"}));
  for (std::size_t k = 1; k + 1 < world.path.size(); k += 97) {
    const Eigen::Vector3d way =
        (world.path[k + 1].translation() - world.path[k - 1].translation()).normalized();
    const Eigen::Matrix3d R = world.path[k].rotation().matrix();
    EXPECT_GT(way.dot(R.col(0)), 1.0 - 1e-5) << k;
    EXPECT_NEAR(R(2, 1), 0.0, 1e-12) << "the second axis is level";
    EXPECT_GT(R(2, 2), 0.0) << "and the third looks up";
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
  }
}

TEST(SpatialWorld, ControlsLeadFromPoseToPose) {
  const SpatialWorld world = make_spatial_world(spatial_scenario({"study.steps=30"}));
  ASSERT_EQ(world.steps(), 30);
  SE3 pose = world.path.front();
  for (const SpatialControl& u : world.controls) {
    // A step turns after it has moved, both in the axes of the vehicle.
    pose = SE3(pose.rotation() * SO3::Exp(u.omega), pose.translation() + pose.rotation() * u.v);
  }
  EXPECT_LT((pose.translation() - world.path.back().translation()).norm(), 1e-10);
  EXPECT_LT((pose.rotation().matrix() - world.path.back().rotation().matrix()).norm(), 1e-11);
}

TEST(SpatialWorld, SeesWhatIsInRangeAndInItsCone) {
  const Scenario scenario =
      spatial_scenario({"world.landmarks=60", "world.sensor_range=30", "world.sensor_min_range=4",
                        "world.field_of_view_deg=120", "study.steps=40"});
  const SpatialWorld world = make_spatial_world(scenario);
  std::size_t seen = 0;
  for (std::size_t k = 0; k < world.path.size(); ++k) {
    std::vector<int> expected;
    for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
      const Eigen::Vector3d d = world.landmarks[i] - world.path[k].translation();
      const Eigen::Vector3d ahead = world.path[k].rotation().matrix().col(0);
      const double angle = std::acos(std::clamp(d.normalized().dot(ahead), -1.0, 1.0));
      if (d.norm() >= 4.0 && d.norm() <= 30.0 && angle <= std::numbers::pi / 3.0) {
        expected.push_back(static_cast<int>(i));
      }
    }
    std::vector<int> numbers;
    for (const SpatialWorld::Exact& exact : world.in_view[k]) {
      numbers.push_back(exact.landmark);
      const Eigen::Vector3d d =
          world.landmarks[static_cast<std::size_t>(exact.landmark)] - world.path[k].translation();
      EXPECT_LT((world.path[k].rotation().matrix() * exact.z - d).norm(), 1e-11);
    }
    EXPECT_EQ(numbers, expected) << k;
    seen += numbers.size();
  }
  EXPECT_GT(seen, 0U);
}

TEST(SpatialWorld, LandmarksAreAFunctionOfTheMapAlone) {
  const auto landmarks = [](const std::vector<std::string>& overrides) {
    return make_spatial_world(spatial_scenario(overrides)).landmarks;
  };
  EXPECT_EQ(landmarks({"study.seed=1"}), landmarks({"study.seed=2", "filter.estimator=fej"}));
  EXPECT_NE(landmarks({"world.map=1"}), landmarks({"world.map=2"}));
  // All within their balls about the path, which a fine polygon of it stands for.
  const SpatialWorld world = make_spatial_world(spatial_scenario(
      {"world.landmark_spread=5", "world.landmarks=300", "world.loop_steps=2000", "study.steps=2000"}));
  double farthest = 0.0;
  for (const Eigen::Vector3d& landmark : world.landmarks) {
    double nearest = 1e9;
    for (const SE3& pose : world.path) nearest = std::min(nearest, (pose.translation() - landmark).norm());
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LE(farthest, 5.0 + 0.1);
  EXPECT_GT(farthest, 2.5);
}

/// Noise against the variances that are told, five standard errors of a variance; and told is what is
/// believed.
TEST(SpatialWorld, NoiseHasTheVariancesOfTheWorldWhateverIsBelieved) {
  for (const char* share_of : {"length", "coordinate"}) {
    const std::string share = std::string("noise.share_of=") + share_of;
    const Scenario scenario =
        spatial_scenario({share, "study.steps=3", "world.sensor_range=200", "filter.process_scale=4",
                          "filter.measurement_scale=9", "world.landmarks=20"});
    const SpatialWorld world = make_spatial_world(scenario);
    ASSERT_FALSE(world.in_view[2].empty());
    SpatialSimulation simulation(world, noise_source(scenario));
    constexpr int kRuns = 4000;
    Eigen::Vector3d of_v = Eigen::Vector3d::Zero(), of_z = of_v, of_start = of_v;
    Eigen::Matrix<double, 6, 1> told_motion;
    Eigen::Vector3d told_z;
    const SpatialWorld::Exact& exact = world.in_view[2].front();
    for (int run = 0; run < kRuns; ++run) {
      const SE3 start = simulation.start(run);
      of_start += (start.translation() - world.path.front().translation()).cwiseAbs2() / kRuns;
      simulation.read(1);
      simulation.observe(1);
      const SpatialControl u = simulation.read(2);
      of_v += (u.v - world.controls[1].v).cwiseAbs2() / kRuns;
      told_motion = u.variances;
      const SpatialObservation seen = simulation.observe(2).front();
      EXPECT_EQ(seen.landmark, exact.landmark);
      of_z += (seen.z - exact.z).cwiseAbs2() / kRuns;
      told_z = seen.variances;
    }
    const double error = 5.0 * std::sqrt(2.0 / kRuns);
    for (Index i = 0; i < 3; ++i) {
      EXPECT_NEAR(of_v[i], told_motion[i] / 4.0, error * told_motion[i] / 4.0) << share_of << i;
      EXPECT_NEAR(of_z[i], told_z[i] / 9.0, error * told_z[i] / 9.0) << share_of << i;
      const double variance = scenario.initial.position_std * scenario.initial.position_std;
      EXPECT_NEAR(of_start[i], variance, error * variance);
    }
    // By length all coordinates have the share of the whole, else each its own.
    const double landmark_share = world.landmark_noise;
    const Eigen::Vector3d expected = share == "noise.share_of=length"
                                         ? Eigen::Vector3d(Eigen::Vector3d::Constant(exact.z.squaredNorm()))
                                         : Eigen::Vector3d(exact.z.cwiseAbs2());
    EXPECT_LT((told_z - 9.0 * landmark_share * landmark_share * expected).norm(), 1e-12 * told_z.norm());
  }
}

}  // namespace
}  // namespace credence::internal
