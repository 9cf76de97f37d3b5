#include "analysis/evidence/play_studies.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

struct ReadyStudy {
  Scenario scenario;
  std::unique_ptr<Experiment> experiment;

  explicit ReadyStudy(const Scenario& of) : scenario(of), experiment(make_experiment(of)) {}
  StudyToPlay study() const { return {configuration_id(scenario), &scenario, experiment.get()}; }
};

Scenario short_monobot(std::int64_t runs) {
  Scenario scenario = default_scenario("monobot");
  scenario.study.runs = runs;
  scenario.study.steps = 12;
  return scenario;
}

TEST(PlayStudies, GivesEachStudyWhatItGetsAlone) {
  Scenario wrong = short_monobot(130);
  wrong.filter.process_scale = 0.25;
  const ReadyStudy a(short_monobot(70)), b(wrong);
  const StudyToPlay both[] = {a.study(), b.study()};
  EngineOptions options;
  options.threads = 2;
  const std::vector<PlayedStudy> together = play_studies(both, options);
  ASSERT_EQ(together.size(), 2U);
  EXPECT_EQ(together[0].result.statistics.runs, 70);
  EXPECT_EQ(together[1].result.statistics.runs, 130);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::vector<PlayedStudy> alone = play_studies({&both[i], 1}, {});
    EXPECT_EQ(to_bytes(alone.front().result.statistics), to_bytes(together[i].result.statistics));
    EXPECT_FALSE(alone.front().stop.has_value());
  }
}

TEST(PlayStudies, EndsWhereTheStopRuleSaysEnough) {
  Scenario scenario = short_monobot(100'000);
  scenario.filter.process_scale = 0.05;
  scenario.stop.verdict = StopVerdict::inconsistent;
  const ReadyStudy wrong(scenario);
  const StudyToPlay study = wrong.study();
  const PlayedStudy played = play_studies({&study, 1}, {}).front();
  ASSERT_TRUE(played.stop.has_value());
  EXPECT_TRUE(played.stop->stop);
  EXPECT_TRUE(is_inconsistent(played.stop->verdict));
  EXPECT_LT(played.result.statistics.runs, 10'000);
  EXPECT_EQ(played.result.statistics.runs % kChunkRuns, 0) << "it looks after whole chunks";
}

TEST(PlayStudies, TakesTheEvidenceWhileItPlays) {
  const ReadyStudy ready(short_monobot(90));
  EvidenceCollector evidence(*ready.experiment, 90);
  StudyToPlay study = ready.study();
  study.evidence = &evidence;
  play_studies({&study, 1}, {});
  const std::optional<Evidence> taken = evidence.take(90);
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(taken->study.runs, 90);
  const std::optional<Evidence> again = collect_evidence(*ready.experiment, 90);
  EXPECT_EQ(to_bytes(taken->study), to_bytes(again->study)) << "and is what playing them once more gives";
}

TEST(PlayStudies, StoppedBeforeTheFirstChunkItHasNoRuns) {
  const ReadyStudy ready(short_monobot(90));
  const StudyToPlay study = ready.study();
  static constexpr std::atomic<bool> kStop{true};
  EngineOptions options;
  options.stop = &kStop;
  const PlayedStudy played = play_studies({&study, 1}, options).front();
  EXPECT_EQ(played.result.statistics.runs, 0);
  EXPECT_FALSE(played.result.complete);
}

}  // namespace
}  // namespace credence::internal
