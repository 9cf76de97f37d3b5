#include "analysis/evidence/sums/play_studies.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "analysis/laws/joint/betting_e_value.h"
#include "montecarlo/scenario/scenario_io.h"
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
  const std::optional<Evidence> again = EvidenceCollector(*ready.experiment, 90).take(90);
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

Scenario drifter(const std::string& filter, const std::string& stop) {
  return load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[0.25]]\nR = [[1]]\n"
      "P0 = [[1]]\nstates = [\"x\"]\n[filter]\n" +
          filter + "[study]\nruns = 640\nsteps = 20\n" + stop,
      "drifter");
}

struct Watched {
  StopDecision decision;
  std::int64_t runs = 0;
};

Watched outcome(const Scenario& scenario, int threads = 1) {
  const auto experiment = make_experiment(scenario);
  SequentialStudy study(scenario);
  StudyTask task{"", experiment.get(), scenario.most_runs()};
  task.enough = [&](const StudyStatistics& chunk, const StudyStatistics& prefix) {
    return study.look(chunk, prefix);
  };
  EngineOptions options;
  options.threads = threads;
  const std::int64_t runs = run_studies({&task, 1}, options).front().statistics.runs;
  return {study.decision(), runs};
}

TEST(SequentialStudy, AWrongFilterEndsTheStudyEarly) {
  const Scenario wrong = drifter("process_scale = 0.01\n", "stop = { verdict = \"inconsistent\" }\n");
  const Watched w = outcome(wrong);
  EXPECT_TRUE(w.decision.stop);
  EXPECT_EQ(w.decision.reason, "verdict");
  EXPECT_EQ(w.decision.verdict, Verdict::optimistic);
  EXPECT_LT(w.runs, 640);
  EXPECT_LE(w.decision.p_value, 0.05);
}

TEST(SequentialStudy, ARightFilterMakesAllItsRunsAndTheLastLookSaysSo) {
  const Watched w = outcome(drifter("", "stop = { verdict = \"inconsistent\" }\n"));
  EXPECT_EQ(w.runs, 640);
  EXPECT_TRUE(w.decision.stop);
  EXPECT_EQ(w.decision.reason, "max_runs");
  EXPECT_FALSE(is_inconsistent(w.decision.verdict));
}

TEST(SequentialStudy, ConsistentIsProvedOnlyWhereEitherWordIsAskedFor) {
  // 20 values a run: a factor within 2 is proved long before 640 runs.
  const Watched either = outcome(drifter("", "stop = { verdict = \"either\", consistent_within = 1.0 }\n"));
  EXPECT_EQ(either.decision.reason, "verdict");
  EXPECT_EQ(either.decision.verdict, Verdict::consistent);
  EXPECT_LT(either.runs, 640);
}

TEST(SequentialStudy, PrecisionEndsItWithoutAVerdict) {
  const Watched w = outcome(drifter("", "stop = { precision = 0.2 }\n"));
  EXPECT_EQ(w.decision.reason, "precision");
  EXPECT_EQ(w.decision.verdict, Verdict::undecided);
  EXPECT_LT(w.runs, 640);
  const MeanInterval& nees = w.decision.mean_nees;
  EXPECT_LE(0.5 * (nees.upper - nees.lower), 0.2 * nees.mean * (1.0 + 1e-12));
}

TEST(SequentialStudy, DecidesTheSameForAnyNumberOfThreads) {
  const Scenario wrong = drifter("process_scale = 0.3\n", "stop = { verdict = \"inconsistent\" }\n");
  const Watched one = outcome(wrong, 1), three = outcome(wrong, 3);
  EXPECT_EQ(one.runs, three.runs);
  EXPECT_EQ(one.decision.p_value, three.decision.p_value);
  EXPECT_EQ(one.decision.scale.upper, three.decision.scale.upper);
}

TEST(SequentialStudy, BetsOnTheRunsOfEachChunkOnce) {
  // What the engine shows chunk by chunk, looked at by hand with one purse.
  const Scenario wrong = drifter("process_scale = 0.3\n", "stop = { verdict = \"inconsistent\" }\n");
  const auto experiment = make_experiment(wrong);
  SequentialStudy study(wrong);
  RunBetting purse;
  StudyStatistics prefix;
  for (std::int64_t first = 0; first < 3 * kChunkRuns; first += kChunkRuns) {
    const StudyStatistics chunk = experiment->run_chunk(first, kChunkRuns);
    first == 0 ? void(prefix = chunk) : prefix.merge(chunk);
    for (const double average : chunk.nees_of_runs.first) purse.add(average, betting_prices(1.0));
    study.look(chunk, prefix);
    const auto nees = prefix.series(Quantity::nees), nis = prefix.series(Quantity::nis);
    const auto nees_dof = prefix.dofs(Quantity::nees), nis_dof = prefix.dofs(Quantity::nis);
    const StopDecision wanted = look({.confidence = 0.95}, {.nees = nees,
                                                            .nees_dof = nees_dof,
                                                            .nis = nis,
                                                            .nis_dof = nis_dof,
                                                            .runs = &prefix.nees_of_runs,
                                                            .betting = &purse});
    EXPECT_EQ(study.decision().log_e_value, wanted.log_e_value) << first;
    EXPECT_EQ(study.decision().stop, wanted.stop) << first;
  }
}

}  // namespace
}  // namespace credence::internal
