#include "analysis/evidence/sequential_study.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "analysis/laws/betting_e_value.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

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
  constexpr std::int64_t kChunk = 64;
  for (std::int64_t first = 0; first < 3 * kChunk; first += kChunk) {
    const StudyStatistics chunk = experiment->run_chunk(first, kChunk);
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
