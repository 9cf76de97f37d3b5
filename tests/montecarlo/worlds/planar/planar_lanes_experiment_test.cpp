#include "montecarlo/worlds/planar/planar_lanes_experiment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/planar/planar_experiment.h"

namespace credence::internal {
namespace {

/// About one run in three starts farther off than 10 km.
Scenario failing_now_and_then() {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 4;
  s.study.steps = 20;
  s.initial.position_std = 8e3;
  return s;
}

NoiseSource source_of(const Scenario& s) { return {s.study.seed, noise_group(s)}; }

PlanarLanesExperiment in_lanes(const Scenario& s) {
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(s);
  return {make_planar_world(s), PlanarNoise::of(s), source_of(s), assumed.Q, assumed.measurement_variance};
}

PlanarExperiment<EkfSlam<PlanarModel>> by_matrices(const Scenario& s) {
  PlanarWorld world = make_planar_world(s);
  auto make_filter = [filter = make_planar_filter(s, world)] { return filter; };
  return {std::move(world), PlanarNoise::of(s), source_of(s), std::move(make_filter)};
}

TEST(PlanarLanesExperiment, RunsThatFailAreCountedNamedAndEndThere) {
  const Scenario scenario = failing_now_and_then();
  const StudyStatistics lanes = in_lanes(scenario).run_chunk(0, 20);
  const StudyStatistics matrices = by_matrices(scenario).run_chunk(0, 20);
  EXPECT_GT(lanes.failures.size(), 2U);
  EXPECT_LT(lanes.failures.size(), 18U);
  EXPECT_EQ(lanes.failures, matrices.failures);
  EXPECT_EQ(lanes.steps[19][Quantity::nees].count, 20 - std::ssize(lanes.failures));
  const RunFailure& failure = lanes.failures.front();
  const RunTrace trace = in_lanes(scenario).trace(failure.run);
  EXPECT_EQ(trace.outcome, Outcome::diverged);
  EXPECT_EQ(std::ssize(trace.steps), failure.step + 1);
  EXPECT_EQ(trace.steps.back().nees_dof, 0);
}

/// Eleven runs, the last lanes of the second batch idle; some fail.
TEST(PlanarLanesExperiment, RunsSideBySideShowWhatEachShowsAlone) {
  const Scenario scenario = failing_now_and_then();
  const PlanarLanesExperiment experiment = in_lanes(scenario);
  constexpr std::int64_t kFirst = 3, kRuns = 11;
  std::vector<std::vector<TraceStep>> seen(kRuns);
  const std::vector<Outcome> outcomes =
      experiment.visit_runs(kFirst, kRuns, [&](std::int64_t run, const TraceStep& step) {
        seen.at(static_cast<std::size_t>(run - kFirst)).push_back(step);
      });
  EXPECT_GT(std::ranges::count(outcomes, Outcome::ok), 1);
  EXPECT_LT(std::ranges::count(outcomes, Outcome::ok), 10);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const RunTrace alone = experiment.trace(kFirst + static_cast<std::int64_t>(i));
    ASSERT_EQ(outcomes[i], alone.outcome) << i;
    ASSERT_EQ(seen[i].size(), alone.steps.size()) << i;
    for (std::size_t k = 0; k < seen[i].size(); ++k) {
      const TraceStep &together = seen[i][k], &one = alone.steps[k];
      ASSERT_EQ(together.step, one.step);
      ASSERT_EQ(together.outcome, one.outcome);
      ASSERT_EQ(together.nees_dof, one.nees_dof);
      if (one.outcome != Outcome::ok) continue;
      ASSERT_EQ(together.error, one.error) << i << " at " << k;
      ASSERT_EQ(together.P, one.P) << i << " at " << k;
      ASSERT_EQ(together.innovation(), one.innovation()) << i << " at " << k;
      ASSERT_EQ(together.S(), one.S()) << i << " at " << k;
    }
  }
}

/// What an observer hears of a chunk, run by run.
class HeardRuns final : public ChunkObserver {
 public:
  struct Run {
    std::vector<std::int64_t> steps;
    RunFailure end;
  };
  void begin_runs(std::int64_t runs) override {
    first_ = heard.size();
    heard.resize(first_ + static_cast<std::size_t>(runs));
  }
  void add(const Step& step, std::size_t i) override { heard.at(first_ + i).steps.push_back(step.step); }
  void add(const NormalisedStep& step, std::size_t i) override {
    heard.at(first_ + i).steps.push_back(step.step);
  }
  void end_run(Outcome outcome, std::int64_t step, std::size_t i) override {
    heard.at(first_ + i).end = {0, step, outcome};
  }

  std::vector<Run> heard;

 private:
  std::size_t first_ = 0;
};

// Of eleven runs each is heard with the steps that went well, and with its end; being heard changes no bit.
TEST(PlanarLanesExperiment, AnObserverHearsEveryRunToItsEnd) {
  const Scenario scenario = failing_now_and_then();
  const PlanarLanesExperiment experiment = in_lanes(scenario);
  HeardRuns observer;
  const auto shown = experiment.show_chunk(3, 11, observer);
  const StudyStatistics plain = experiment.run_chunk(3, 11);
  ASSERT_TRUE(shown.has_value());
  EXPECT_EQ(*shown, plain);
  ASSERT_EQ(observer.heard.size(), 11U);
  std::size_t failures = 0;
  for (std::size_t i = 0; i < 11; ++i) {
    const HeardRuns::Run& run = observer.heard[i];
    const auto steps = static_cast<std::int64_t>(run.steps.size());
    for (std::int64_t k = 1; k <= steps; ++k) EXPECT_EQ(run.steps[static_cast<std::size_t>(k - 1)], k);
    if (run.end.outcome == Outcome::ok) {
      EXPECT_EQ(run.end.step, 20) << i;
      EXPECT_EQ(steps, 20) << i;
      continue;
    }
    ASSERT_LT(failures, plain.failures.size());
    const RunFailure& counted = plain.failures[failures++];
    EXPECT_EQ(counted.run, 3 + static_cast<std::int64_t>(i));
    EXPECT_EQ(counted.step, run.end.step);
    EXPECT_EQ(counted.outcome, run.end.outcome);
    EXPECT_EQ(steps, run.end.step - 1) << i;
  }
  EXPECT_EQ(failures, plain.failures.size());
  EXPECT_GT(failures, 1U);
}

// Runs beyond the last lane idle: a chunk is the sum of its parts, wherever it is cut.
TEST(PlanarLanesExperiment, AChunkCountsItsRunsWhereverItIsCut) {
  const Scenario scenario = failing_now_and_then();
  const PlanarLanesExperiment experiment = in_lanes(scenario);
  const StudyStatistics whole = experiment.run_chunk(0, 19);
  std::int64_t runs = 0, counted = 0;
  std::vector<RunFailure> failures;
  double sum = 0.0;
  for (const auto& [first, count] : {std::pair(0, 1), std::pair(1, 8), std::pair(9, 10)}) {
    const StudyStatistics part = experiment.run_chunk(first, count);
    runs += part.runs;
    counted += part.steps[19][Quantity::nees].count;
    sum += static_cast<double>(part.steps[19][Quantity::nees].count) * part.steps[19][Quantity::nees].mean;
    failures.insert(failures.end(), part.failures.begin(), part.failures.end());
  }
  EXPECT_EQ(runs, whole.runs);
  EXPECT_EQ(failures, whole.failures);
  EXPECT_EQ(counted, whole.steps[19][Quantity::nees].count);
  const double mean = whole.steps[19][Quantity::nees].mean;
  EXPECT_NEAR(sum / static_cast<double>(counted), mean, 1e-12 * mean);
}

}  // namespace
}  // namespace credence::internal
