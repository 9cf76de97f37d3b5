#include "montecarlo/worlds/posterior_bound.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario scenario_of(const std::string& world, const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"" + world + "\"\n", "t.toml", overrides);
}

PosteriorBound bound_of(const std::string& world, const std::vector<std::string>& overrides = {}) {
  return posterior_bound(scenario_of(world, overrides)).value();
}

/// The mean of what the filter claims of a block, over the steps of one run.
double claimed_of(const std::string& world, const std::vector<std::string>& overrides,
                  const std::string& block) {
  const Scenario scenario = scenario_of(world, overrides);
  const auto experiment = world_of(scenario).experiment(scenario);
  double sum = 0.0;
  for (const Block& b : experiment->layout().blocks) {
    if (b.name != block) continue;
    experiment->visit(0, [&](const TraceStep& step) {
      if (step.step > 0) sum += step.P.diagonal()(b.states).sum();
    });
  }
  return sum / static_cast<double>(scenario.study.steps);
}

TEST(PosteriorBound, IsNotAboveWhatJacobiansAtTheTruthClaim) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> worlds = {
      {"pendulum", {"study.steps=100"}},
      {"tracking", {"world.sensor=range_bearing", "study.steps=50"}},
      {"localisation", {"study.steps=500", "world.aiding=landmarks"}},
      {"inertial", {"study.steps=300", "world.aiding=landmarks"}},
      {"planar", {"study.steps=200"}},
      {"planar_slam", {"study.steps=100"}},
      {"spatial_slam", {"study.steps=50", "world.landmarks=20"}}};
  for (const auto& [world, overrides] : worlds) {
    const PosteriorBound bound = bound_of(world, overrides);
    EXPECT_EQ(bound.reason, "") << world;
    EXPECT_FALSE(bound.blocks.empty()) << world;
    for (const BoundCurve& curve : bound.blocks) {
      for (std::size_t k = 0; k < curve.bound.size(); ++k) {
        if (std::isnan(curve.at_truth[k])) continue;
        EXPECT_LE(curve.bound[k], curve.at_truth[k] * (1.0 + 1e-9))
            << world << ' ' << curve.block << ' ' << k;
        EXPECT_GE(curve.bound[k], 0.0);
      }
    }
  }
}

// With little noise all truths are one, and the filter linearises there: bound and P meet. By block, and in
// proportion to the noise, which a wrong Q, R or P0 would not be.
TEST(PosteriorBound, MeetsPAsNoiseVanishes) {
  struct Case {
    std::string world;
    std::vector<std::string> overrides;
    std::vector<std::string> blocks;
  };
  const std::vector<Case> cases = {
      {"planar",
       {"study.steps=150", "world.landmarks=5", "noise.speed_std=1e-5", "noise.turn_rate_std=1e-5",
        "noise.range_std=1e-4", "noise.bearing_std_deg=1e-3", "initial.position_std=1e-5",
        "initial.heading_std_deg=1e-3"},
       {"position", "heading"}},
      {"planar",
       {"study.steps=150", "world.landmarks=5", "world.observability=full", "noise.speed_std=1e-5",
        "noise.turn_rate_std=1e-5", "noise.range_std=1e-4", "noise.bearing_std_deg=1e-3",
        "initial.position_std=1e-5", "initial.heading_std_deg=1e-3"},
       {"position", "heading"}},
      {"pendulum",
       {"study.steps=100", "noise.angular_acceleration_density=1e-8", "noise.displacement_std=1e-4",
        "initial.angle_std_deg=1e-3", "initial.angular_velocity_std=1e-5"},
       {"angle", "angular_velocity"}},
      {"tracking",
       {"world.sensor=range_bearing", "study.steps=40", "noise.acceleration_density=1e-8",
        "noise.range_std=1e-3", "noise.bearing_std_deg=1e-4", "initial.position_std=1e-3",
        "initial.velocity_std=1e-3"},
       {"position", "velocity"}},
      {"localisation",
       {"world.aiding=landmarks", "study.steps=400", "noise.speed_std=1e-5", "noise.turn_rate_std=1e-5",
        "noise.relative_position_std=1e-3", "initial.position_std=1e-4", "initial.heading_std_deg=1e-3"},
       {"position", "heading"}},
      {"inertial",
       {"world.aiding=landmarks", "study.steps=300", "noise.gyro_density=1e-7",
        "noise.accelerometer_density=1e-6", "noise.relative_position_std=1e-3", "initial.position_std=1e-4",
        "initial.velocity_std=1e-4", "initial.attitude_std_deg=1e-3"},
       {"position", "velocity", "attitude"}}};
  for (const Case& c : cases) {
    const PosteriorBound bound = bound_of(c.world, c.overrides);
    ASSERT_EQ(bound.reason, "") << c.world;
    for (const std::string& block : c.blocks) {
      const double P = claimed_of(c.world, c.overrides, block);
      ASSERT_GT(P, 0.0) << c.world << ' ' << block;
      ASSERT_NE(bound.find(block), nullptr) << c.world << ' ' << block;
      EXPECT_NEAR(bound.find(block)->mean_bound() / P, 1.0, 2e-3) << c.world << ' ' << block;
      EXPECT_NEAR(bound.find(block)->mean_at_truth() / P, 1.0, 2e-3) << c.world << ' ' << block;
    }
  }
}

TEST(PosteriorBound, OfAMapStartsOnceEveryLandmarkWasSeen) {
  const PosteriorBound bound = bound_of(
      "planar", {"study.steps=400", "world.sensor_range=12", "world.landmarks=10", "world.path_radius=10"});
  const BoundCurve& map = *bound.find("all landmarks");
  EXPECT_TRUE(std::isnan(map.bound.front()));
  EXPECT_FALSE(std::isnan(map.bound.back()));
  for (std::size_t k = 0; k < map.bound.size(); ++k) {
    EXPECT_EQ(std::isnan(map.bound[k]), std::isnan(map.at_truth[k]))
        << "errors are of what a run knows: " << k;
  }
  EXPECT_EQ(bound.find("pose"), nullptr);
  EXPECT_EQ(bound.find("landmark 1"), nullptr);
}

TEST(PosteriorBound, ThatIsNotThereHasAReason) {
  EXPECT_THAT(bound_of("planar", {"noise.outlier_rate=0.05"}).reason, HasSubstr("Gaussian"));
  EXPECT_THAT(bound_of("localisation", {"noise.measurement_delay=2"}).reason, HasSubstr("in time"));
  EXPECT_THAT(bound_of("planar_slam", {"noise.outlier_rate=0.05"}).reason, HasSubstr("Gaussian"));
  EXPECT_THAT(bound_of("spatial_slam", {"noise.measurement_delay=2"}).reason, HasSubstr("in time"));
  EXPECT_THAT(bound_of("pendulum", {"noise.angular_acceleration_density=0"}).reason, HasSubstr("singular"));
  EXPECT_THAT(bound_of("planar", {"noise.range_std=0"}).reason, HasSubstr("that have noise"));
  EXPECT_THAT(bound_of("planar", {"noise.bearing_std_deg=0"}).reason, HasSubstr("that have noise"));
  EXPECT_THAT(bound_of("planar_slam", {"world.landmark_sensor=range_bearing", "noise.range_std=0"}).reason,
              HasSubstr("that have noise"));
  EXPECT_THAT(bound_of("tracking", {"world.sensor=range_bearing", "noise.range_std=0"}).reason,
              HasSubstr("that have noise"));
  EXPECT_THAT(bound_of("localisation", {"noise.position_std=0"}).reason, HasSubstr("that have noise"));
  EXPECT_THAT(bound_of("planar", {"world.landmarks=2000"}).reason, HasSubstr("too many"));
  EXPECT_THAT(bound_of("planar_slam", {"filter.estimator=invariant"}).reason, HasSubstr("differences"));
  EXPECT_THAT(bound_of("spatial_slam", {"filter.estimator=invariant"}).reason, HasSubstr("differences"));
}

}  // namespace
}  // namespace credence::internal
