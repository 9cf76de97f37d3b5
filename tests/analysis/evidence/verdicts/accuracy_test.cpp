#include "analysis/evidence/verdicts/accuracy.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <utility>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/evidence_recorder.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

// Two runs of two steps: errors 3, 4 m and 1, 2 m in the position, 0.1 rad in the angle.
Evidence two_runs(const std::vector<std::string>& units = {}) {
  RunLayout layout{.states = {"position.x", "position.y", "tilt.a", "odd.a", "odd.m", "known.k"},
                   .angles = {false, false, true, true, false, false},
                   .units = units};
  add_named_blocks(layout);
  layout.blocks.front().part = Part::position;
  EvidenceRecorder recorder(layout);
  Step step;
  step.states = {0, 1, 2, 3, 4, 5};
  step.P = Matrix::Identity(6, 6);
  step.P(0, 0) = 2.0;
  step.P(5, 5) = 0.0;
  for (const double scale : {1.0, 2.0}) {
    recorder.begin_run();
    step.P.topLeftCorner(3, 3) *= scale;
    for (step.step = 1; step.step <= 2; ++step.step) {
      const double x = scale == 1.0 ? 3.0 : 1.0;
      step.error = (Vector(6) << x, x + 1.0, 0.1, 0.1, 1.0, 0.0).finished();
      recorder.add(step);
    }
  }
  return recorder.take();
}

TEST(BlockAccuracy, IsTheMeanOverStepsAndRunsBesideP) {
  const std::vector<BlockAccuracy> all = block_accuracy(two_runs({"m", "m", "rad", "rad", "m", "m"}), 0.95);
  ASSERT_EQ(all.size(), 2U);  // what mixes angles with others has no unit, what is known exactly no accuracy
  EXPECT_EQ(all[0].of, "position");
  EXPECT_EQ(all[0].unit, "m");
  EXPECT_NEAR(all[0].squared_error.mean, (25.0 + 5.0) / 2.0, 1e-12);
  EXPECT_LT(all[0].squared_error.lower, 15.0);
  EXPECT_NEAR(all[0].claimed, (3.0 + 6.0) / 2.0, 1e-12);
  EXPECT_EQ(all[1].unit, "rad");
  EXPECT_NEAR(all[1].squared_error.mean, 0.01, 1e-15);
  EXPECT_TRUE(std::isnan(all[0].bound));
  EXPECT_EQ(all[0].efficiency().count, 0);
}

TEST(BlockAccuracy, HasTheUnitOfItsStatesInTheLayout) {
  const auto units = [](std::vector<std::string> of_states) {
    std::vector<std::string> of_blocks;
    for (const BlockAccuracy& row : block_accuracy(two_runs(std::move(of_states)), 0.95)) {
      of_blocks.push_back(row.unit);
    }
    return of_blocks;
  };
  using testing::ElementsAre;
  EXPECT_THAT(units({}), ElementsAre("", "rad")) << "of angles it is known";
  EXPECT_THAT(units({"km", "km", "rad", "rad", "m", "s"}), ElementsAre("km", "rad"));
  EXPECT_THAT(units({"km", "m", "", "", "", ""}), ElementsAre("", "rad")) << "they differ";
}

TEST(BlockAccuracy, SetsTheBoundBesideIt) {
  std::vector<BlockAccuracy> all = block_accuracy(two_runs(), 0.95);
  PosteriorBound bound;
  bound.blocks = {{.block = "position", .bound = {3.0, 6.0}, .at_truth = {4.0, 8.0}},
                  {.block = "not there", .bound = {1.0, 1.0}, .at_truth = {1.0, 1.0}}};
  add_bound(bound, {}, 0.95, all);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].bound, 4.5);
  EXPECT_EQ(all[0].at_truth, 6.0);
  const MeanInterval efficiency = all[0].efficiency();
  EXPECT_NEAR(efficiency.mean, 4.5 / 15.0, 1e-15);
  EXPECT_NEAR(efficiency.upper, 4.5 / all[0].squared_error.lower, 1e-12);
  EXPECT_NEAR(efficiency.lower, 4.5 / all[0].squared_error.upper, 1e-12);
}

TEST(BlockAccuracy, OfAMapIsComparedAtTheLastStep) {
  std::vector<BlockAccuracy> all = {{.of = "all landmarks", .unit = "km"}, {.of = "other"}};
  PosteriorBound bound;
  bound.blocks = {{.block = "all landmarks", .bound = {kNaN, 2.0}, .at_truth = {kNaN, 3.0}}};
  StudyStatistics statistics;
  statistics.steps.resize(2);
  for (const double x : {7.0, 9.0}) statistics.steps[1][Quantity::landmark_error_squared].add(x);
  statistics.steps[1][Quantity::landmark_variance].add(4.0);
  add_bound(bound, statistics, 0.95, all);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1].of, "all landmarks, last step");
  EXPECT_EQ(all[1].unit, "km");
  EXPECT_EQ(all[1].squared_error.mean, 8.0);
  EXPECT_EQ(all[1].claimed, 4.0);
  EXPECT_EQ(all[1].bound, 2.0);
  EXPECT_EQ(all[1].at_truth, 3.0);
  EXPECT_TRUE(std::isnan(all[0].bound));
}

// A filter whose chart makes the world all but linear reaches the bound.
TEST(BlockAccuracy, OfAnEfficientFilterMeetsTheBound) {
  const std::vector<std::string> overrides = {"initial.heading_std_deg=3", "study.steps=600",
                                              "study.runs=400"};
  const Scenario scenario = load_scenario_text("[world]\nmodel = \"localisation\"\n", "t.toml", overrides);
  const auto experiment = world_of(scenario).experiment(scenario);
  const StudyTask task{.id = {}, .experiment = experiment.get(), .runs = 400, .steps = 600};
  StudyResult result = run_studies({&task, 1}, {.threads = 2}).front();
  StudyAnalysis analysis = analyse_study(scenario, *experiment, std::move(result));
  add_judgement(analysis, *experiment);
  const std::atomic<bool> stop{true};
  add_posterior_bound(analysis, {.stop = &stop});
  EXPECT_FALSE(std::exchange(analysis.complete, true)) << "an interruption is no bound";
  EXPECT_FALSE(analysis.bound.has_value());
  add_posterior_bound(analysis);
  EXPECT_TRUE(analysis.complete);
  ASSERT_TRUE(analysis.bound.has_value());
  ASSERT_EQ(analysis.judgement->accuracy.size(), 2U);
  for (const BlockAccuracy& block : analysis.judgement->accuracy) {
    const MeanInterval efficiency = block.efficiency();
    EXPECT_NEAR(block.claimed / block.bound, 1.0, 0.01) << block.of;
    EXPECT_NEAR(efficiency.mean, 1.0, 5.0 * efficiency.standard_error) << block.of;
    EXPECT_LT(efficiency.standard_error, 0.1);
  }
}

}  // namespace
}  // namespace credence::internal
