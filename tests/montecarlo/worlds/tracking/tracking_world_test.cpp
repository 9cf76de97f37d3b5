#include "montecarlo/worlds/tracking/tracking_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/engine/study_of_runs.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario tracking_scenario(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"tracking\"\n", "t.toml", overrides);
}

std::string tracking_refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { tracking_scenario(overrides); });
}

// [Bar-Shalom 2001], eqs (6.2.2-4) and (6.2.2-12), with T = 0.5 and q = 0.2.
TEST(TrackingWorld, HasTheModelOfTheBook) {
  const LinearProblem p =
      linear_problem(
          tracking_scenario({"world.dimensions=3", "world.dt=0.5", "noise.acceleration_density=0.2",
                             "noise.position_std=2", "initial.velocity_std=3", "filter.process_scale=2"}))
          .value();
  ASSERT_EQ(p.truth.state_dim(), 6);
  EXPECT_EQ(p.truth.F(1, 4), 0.5);
  EXPECT_EQ(p.truth.F(1, 3), 0.0);
  EXPECT_DOUBLE_EQ(p.truth.Q(2, 2), 0.2 * 0.125 / 3.0);
  EXPECT_DOUBLE_EQ(p.truth.Q(2, 5), 0.2 * 0.125);
  EXPECT_DOUBLE_EQ(p.truth.Q(5, 5), 0.1);
  EXPECT_EQ(p.assumed.Q, Matrix(2.0 * p.truth.Q));
  EXPECT_EQ(p.truth.R, Matrix(4.0 * Matrix::Identity(3, 3)));
  EXPECT_EQ(p.truth.P0(0, 0), 100.0);
  EXPECT_EQ(p.truth.P0(5, 5), 9.0);
  EXPECT_EQ(p.scene.layout.states[4], "velocity.y");
  ASSERT_EQ(p.scene.layout.blocks.size(), 2U);
  EXPECT_EQ(p.scene.layout.blocks[0].part, Part::position);
  EXPECT_EQ(p.scene.layout.blocks[1].name, "velocity");
}

TEST(TrackingWorld, KeysBelongToTheirSensor) {
  EXPECT_EQ(tracking_refusal({"world.sensor=range_bearing", "noise.range_std=2"}), "accepted");
  EXPECT_THAT(tracking_refusal({"noise.range_std=2"}),
              HasSubstr("accepted only with world.model = \"planar\", or with world.model = \"tracking\" and "
                        "world.sensor = \"range_bearing\""));
  EXPECT_THAT(tracking_refusal({"world.sensor=range_bearing", "noise.position_std=2"}),
              HasSubstr("accepted only with world.model = \"tracking\" and world.sensor = \"position\""));
  EXPECT_THAT(tracking_refusal({"world.sensor=range_bearing", "world.dimensions=3"}),
              HasSubstr("must be 2 with world.sensor = \"range_bearing\""));
  EXPECT_THAT(tracking_refusal({"world.dimensions=4"}), HasSubstr("an integer from 1 to 3"));
  const Scenario s = tracking_scenario({"world.sensor=range_bearing", "initial.velocity_std=2"});
  Scenario again = load_scenario_text(canonical_toml(s), "t.toml");
  EXPECT_EQ(again, s);
}

// A filter that knows the truth: E[NEES] = 2d, E[NIS] = d, in lanes.
TEST(TrackingWorld, PositionsAreTrackedConsistently) {
  for (const int d : {1, 2, 3}) {
    const auto experiment = make_experiment(tracking_scenario({"world.dimensions=" + std::to_string(d)}));
    const StudyStatistics statistics = study_of_runs(*experiment, 4000, 1);
    for (const std::size_t k : {0U, 20U, 99U}) {
      const double n = 2.0 * d, runs = 4000.0;
      EXPECT_NEAR(statistics.steps[k][Quantity::nees].mean, n, 5.0 * std::sqrt(2.0 * n / runs))
          << d << ' ' << k;
      EXPECT_NEAR(statistics.steps[k][Quantity::nis].mean, d, 5.0 * std::sqrt(2.0 * d / runs))
          << d << ' ' << k;
    }
  }
}

TEST(TrackingWorld, ThreadsAndChunksGiveTheSameBits) {
  for (const auto& variant : std::vector<std::vector<std::string>>{
           {},
           {"noise.detection_probability=0.5"},
           {"world.sensor=range_bearing"},
           {"world.sensor=range_bearing", "noise.detection_probability=0.5"}}) {
    const auto experiment = make_experiment(tracking_scenario(variant));
    EXPECT_EQ(to_bytes(study_of_runs(*experiment, 200, 1)), to_bytes(study_of_runs(*experiment, 200, 2)));
    const StudyStatistics one = experiment->run_chunk(7, 1);
    const RunTrace trace = experiment->trace(7);
    for (std::size_t k = 1; k < trace.steps.size(); ++k) {
      EXPECT_NEAR(one.steps[k - 1][Quantity::nees].mean, trace.steps[k].nees,
                  1e-12 * (10.0 + trace.steps[k].nees));
    }
  }
}

}  // namespace
}  // namespace credence::internal
