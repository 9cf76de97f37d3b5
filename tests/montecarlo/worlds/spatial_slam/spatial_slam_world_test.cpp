#include "montecarlo/worlds/world_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/filters/spatial/spatial_slam.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario in_space(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"spatial_slam\"\n", "t.toml", overrides);
}

std::string space_refusal(const std::vector<std::string>& overrides) {
  return scenario_refusal([&] { in_space(overrides); });
}

TEST(SpatialSlamWorld, RefusesNamingItsKeys) {
  EXPECT_THAT(space_refusal({"world.landmarks=0"}), HasSubstr("must be >= 1"));
  EXPECT_THAT(space_refusal({"world.sensor_min_range=20"}), HasSubstr("must be < world.sensor_range = 20"));
  EXPECT_THAT(space_refusal({"filter.estimator=oc"}), HasSubstr("filter.estimator=oc"));
  EXPECT_THAT(space_refusal({"filter.inflation=map"}), HasSubstr("accepted only with world.model"));
  for (const char* bad : {"noise.odometry_share=0", "world.path_length=0", "noise.share_of=lenght"}) {
    const std::string key = std::string(bad).substr(0, std::string(bad).find('='));
    EXPECT_THAT(space_refusal({bad}), HasSubstr("--set " + key + "=")) << bad;
  }
}

TEST(SpatialSlamWorld, EstimatorsShareTheirNoise) {
  EXPECT_EQ(noise_group(in_space()), noise_group(in_space({"filter.estimator=invariant"})));
  EXPECT_NE(configuration_id(in_space()), configuration_id(in_space({"filter.estimator=invariant"})));
  EXPECT_NE(noise_group(in_space()), noise_group(in_space({"world.map=2"})));
}

// What is judged is the pose, in the chart of the estimator; a visit has the numbers of its chunk.
TEST(SpatialSlamWorld, EveryEstimatorIsJudgedByItsPose) {
  for (const SpatialKind& kind : spatial_kinds()) {
    const auto experiment = make_experiment(in_space(
        {"study.steps=15", "world.landmarks=40", std::string("filter.estimator=") + std::string(kind.name)}));
    EXPECT_EQ(experiment->layout().states.size(), 6U);
    EXPECT_EQ(experiment->layout().componentwise, kind.chart == SpatialChart::componentwise) << kind.name;
    const RunTrace trace = experiment->trace(3);
    const StudyStatistics chunk = experiment->run_chunk(3, 1);
    ASSERT_EQ(trace.steps.size(), 16U);
    for (std::size_t k = 1; k <= 15; ++k) {
      const TraceStep& step = trace.steps[k];
      const double nees = step.error.dot(step.P.llt().solve(step.error));
      EXPECT_EQ(step.nees_dof, 6);
      EXPECT_NEAR(step.nees, nees, 1e-8 * (1.0 + nees)) << kind.name;
      EXPECT_NEAR(chunk.steps[k - 1][Quantity::nees].mean, step.nees, 1e-12 * (1.0 + step.nees));
      EXPECT_LT((step.error - (step.estimate - step.truth)).norm(), 1e-12 * step.truth.norm());
    }
  }
}

TEST(SpatialSlamWorld, SaysItsSizeAndHasABoundOfDifferencesAlone) {
  const Scenario scenario = in_space({"world.landmarks=70", "noise.detection_probability=0.5"});
  EXPECT_THAT(world_text(scenario),
              testing::AllOf(HasSubstr("70 landmarks"), HasSubstr("with probability 0.5")));
  EXPECT_EQ(kSpatialSlamWorld.size_text(scenario), "world.landmarks = 70");
  // A dense P of 6 + 3 N states, and nothing that grows faster with the steps than a pose.
  EXPECT_GE(kSpatialSlamWorld.least_doubles(scenario), 216.0 * 216.0);
  EXPECT_EQ(posterior_bound(in_space({"filter.estimator=invariant"})).value().reason, kBoundOfDifferences);
}

}  // namespace
}  // namespace credence::internal
