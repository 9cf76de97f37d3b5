#include "analysis/evidence/sums/evidence_collect.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/evidence_bytes.h"
#include "analysis/evidence/sums/evidence_recorder.h"
#include "core/nan.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

/// The evidence of the first runs, played for that alone.
std::optional<Evidence> collect_evidence(const Experiment& experiment, std::int64_t runs,
                                         const EngineOptions& options) {
  return EvidenceCollector(experiment, runs).take(runs, options);
}

Scenario monobot(std::int64_t runs) {
  Scenario s = default_scenario("monobot");
  s.world.landmarks = 2;
  s.study.runs = runs;
  s.study.steps = 60;
  s.study.seed = 5;
  return s;
}

Scenario planar() {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 6;
  s.study.runs = 70;
  s.study.steps = 40;
  s.study.seed = 3;
  return s;
}

StudyAnalysis analysed(const Scenario& scenario) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  StudyAnalysis analysis = analyse_study(scenario, *experiment, run_studies({&task, 1}, {}).front());
  add_judgement(analysis, *experiment);
  return analysis;
}

const NamedTest& test_of(const Judgement& judgement, const std::string& name) {
  const auto found = std::ranges::find(judgement.tests, name, &NamedTest::name);
  if (found == judgement.tests.end()) throw std::runtime_error("no test " + name);
  return *found;
}

bool names(const Judgement& judgement, Cause cause) {
  return std::ranges::any_of(judgement.causes, [&](const CauseFound& c) { return c.cause == cause; });
}

// A state too large to be whitened whole is looked at in few runs alone: of a chunk of more none is one of
// them, nor is one of a later chunk.
TEST(CollectedEvidence, StretchesOfALargeStateAreOfFewRunsAlone) {
  const auto runs_of = [](std::int64_t runs) {
    const auto experiment = make_experiment(planar());
    return collect_evidence(*experiment, runs, {}).value().law.stretches.runs;
  };
  EXPECT_EQ(runs_of(StretchSums::kMostRuns), StretchSums::kMostRuns);
  EXPECT_EQ(runs_of(StretchSums::kMostRuns + 1), 0);
  EXPECT_EQ(runs_of(kChunkRuns + 3), 0);
}

TEST(CollectedEvidence, NamesLateMeasurements) {
  const auto judged = [](const std::string& model, const std::string& setting) {
    const std::string text =
        "[world]\nmodel = \"" + model + "\"\n[study]\nruns = 64\nsteps = 60\n" +
        (model == "planar" ? "" : "[initial]\nvelocity_std = 5.0\n[filter]\nprocess_scale = 1.0\n");
    return analysed(load_scenario_text(text, "t.toml", std::vector<std::string>{setting})).judgement.value();
  };
  for (const std::string model : {"tracking", "planar"}) {
    for (const char* other :
         {"noise.measurement_delay=0", "filter.process_scale=0.1", "noise.measurement_correlation=0.5"}) {
      EXPECT_FALSE(names(judged(model, other), Cause::late_measurements)) << model << ' ' << other;
    }
    for (const std::string delay : {"1", "3"}) {
      const Judgement judgement = judged(model, "noise.measurement_delay=" + delay);
      ASSERT_FALSE(judgement.causes.empty()) << model << ' ' << delay;
      EXPECT_EQ(judgement.causes.front().cause, Cause::late_measurements) << judgement.causes.front().why;
    }
  }
}

TEST(CollectedEvidence, PassesAnOptimalFilter) {
  const StudyAnalysis analysis = analysed(monobot(320));
  const Judgement& judgement = analysis.judgement.value();
  EXPECT_EQ(judgement.runs, 320);
  EXPECT_EQ(judgement.tests.size(), 2U + 4U + 6U + 5U + 4U);
  for (const NamedTest& test : judgement.tests) {
    // The chance of a false alarm anywhere in the judgement, at this one seed, is below 0.1 %.
    EXPECT_GT(test.adjusted, 1e-3) << test.name << ": " << test.says;
  }
  EXPECT_TRUE(judgement.causes.empty());
  EXPECT_EQ(judgement.responsible.index, -1);
  EXPECT_FALSE(judgement.responsible.joint_only);
}

TEST(CollectedEvidence, SeesTheSameNumbersAsTheEngine) {
  for (const Scenario& scenario : {monobot(70), planar()}) {
    const StudyAnalysis analysis = analysed(scenario);
    const auto experiment = make_experiment(scenario);
    const Evidence s = collect_evidence(*experiment, 70, {.threads = 1}).value();
    Moments nees;
    for (const StepStatistics& step : analysis.statistics.steps) nees.merge(step[Quantity::nees]);
    ASSERT_EQ(s.whole_runs.nees_values.count, nees.count);
    EXPECT_NEAR(s.whole_runs.nees_values.mean, nees.mean, 1e-10 * nees.mean);
    EXPECT_NEAR(s.whole_runs.nees_values.m2, nees.m2, 1e-9 * nees.m2);
    if (!analysis.vehicle_nees) continue;
    for (std::size_t k = 0; k < analysis.statistics.steps.size(); ++k) {
      const Moments& pose = analysis.statistics.steps[k][Quantity::vehicle_nees];
      EXPECT_EQ(s.blocks[0].nees[k].value.count, pose.count);
      EXPECT_NEAR(s.blocks[0].nees[k].value.mean, pose.mean, 1e-9 * pose.mean) << "step " << k + 1;
    }
  }
}

TEST(CollectedEvidence, IsTheSameForAnyNumberOfThreads) {
  const Scenario scenario = planar();
  const auto experiment = make_experiment(scenario);
  const Evidence one = collect_evidence(*experiment, 70, {.threads = 1}).value();
  const Evidence three = collect_evidence(*experiment, 70, {.threads = 3}).value();
  const SensorSums &sensor = one.sensors[0], &same = three.sensors[0];
  EXPECT_EQ(sensor.fit, same.fit);
  EXPECT_EQ(sensor.far_tail, same.far_tail);
  EXPECT_EQ(sensor.run_means.scatter, same.run_means.scatter);
  for (Index lag = 0; lag <= LongLags::kLags; ++lag) {
    EXPECT_EQ(sensor.lags.of_values().product(lag), same.lags.of_values().product(lag));
  }
  for (std::size_t b = 0; b < one.blocks.size(); ++b) {
    EXPECT_EQ(one.blocks[b].nees, three.blocks[b].nees) << one.blocks[b].name;
  }
  EXPECT_EQ(one.whole_runs.nees, three.whole_runs.nees);
}

/// The runs of another one as plain steps: each alone, or side by side.
class AnotherWay final : public Experiment {
 public:
  AnotherWay(const Experiment& inner, bool alone)
      : Experiment(inner.layout()), inner_(inner), alone_(alone) {}
  StudyStatistics run_chunk(std::int64_t first, std::int64_t runs) const override {
    return inner_.run_chunk(first, runs);
  }
  Outcome visit(std::int64_t run, const StepVisitor& take) const override { return inner_.visit(run, take); }
  std::int64_t runs_side_by_side() const override { return alone_ ? 1 : inner_.runs_side_by_side(); }
  std::vector<Outcome> visit_runs(std::int64_t first, std::int64_t runs,
                                  const RunsVisitor& take) const override {
    return inner_.visit_runs(first, runs, take);
  }
  RunTrace describe_world() const override { return {}; }

 private:
  const Experiment& inner_;
  bool alone_;
};

TEST(CollectedEvidence, IsTheSameOfRunsSideBySide) {
  Scenario scenario = planar();
  scenario.initial.position_std = 8e3;  // some runs fail, and end before others
  const auto experiment = make_experiment(scenario);
  ASSERT_GT(experiment->runs_side_by_side(), 1);
  const Evidence one = collect_evidence(AnotherWay(*experiment, true), 70, {.threads = 1}).value();
  const Evidence together = collect_evidence(AnotherWay(*experiment, false), 70, {.threads = 1}).value();
  EXPECT_EQ(together.rows, one.rows);
  EXPECT_FALSE(one.study.failures.empty());
  EXPECT_EQ(together.study, one.study);
  EXPECT_EQ(together.whole_runs.nees, one.whole_runs.nees);
  const SensorSums &sensor = together.sensors[0], &same = one.sensors[0];
  EXPECT_EQ(sensor.fit, same.fit);
  EXPECT_EQ(sensor.by_dimension, same.by_dimension);
  EXPECT_EQ(sensor.measurement_share, same.measurement_share);
  EXPECT_EQ(sensor.components, same.components);
  EXPECT_EQ(sensor.pairs, same.pairs);
  EXPECT_EQ(sensor.run_means.scatter, same.run_means.scatter);
  EXPECT_EQ(sensor.lags.of_values().product(3), same.lags.of_values().product(3));
  for (std::size_t b = 0; b < one.blocks.size(); ++b) {
    EXPECT_EQ(together.blocks[b].nees, one.blocks[b].nees) << one.blocks[b].name;
  }
}

TEST(CollectedEvidence, OfNormalisedStepsIsThatOfPlainOnes) {
  for (const Index landmarks : {Index{0}, Index{6}, Index{45}}) {  // lanes, without a map, with one; a matrix
    Scenario scenario = planar();
    scenario.world.landmarks = landmarks;
    if (landmarks == 0) {
      scenario.world.observability = Observability::full;
      scenario.world.anchors = 2;
    }
    const auto experiment = make_experiment(scenario);
    const Evidence fast = collect_evidence(*experiment, 10, {.threads = 1}).value();
    const Evidence plain = collect_evidence(AnotherWay(*experiment, true), 10, {.threads = 1}).value();
    const auto near = [](double a, double b) { EXPECT_NEAR(a, b, 1e-7 * (1.0 + std::abs(b))); };
    EXPECT_EQ(fast.rows, plain.rows);
    ASSERT_EQ(fast.blocks.size(), plain.blocks.size());
    for (std::size_t b = 0; b < fast.blocks.size(); ++b) {
      SCOPED_TRACE(fast.blocks[b].name);
      ASSERT_EQ(fast.blocks[b].nees.size(), plain.blocks[b].nees.size());
      near(fast.blocks[b].runs.moments.mean, plain.blocks[b].runs.moments.mean);
      near(fast.blocks[b].squared_error.mean, plain.blocks[b].squared_error.mean);
      near(fast.blocks[b].nees.back().value.mean, plain.blocks[b].nees.back().value.mean);
    }
    ASSERT_EQ(fast.lateness.runs.mean.size(), plain.lateness.runs.mean.size());
    ASSERT_GT(fast.lateness.runs.mean.size(), 0);
    for (Index i = 0; i < fast.lateness.runs.mean.size(); ++i)
      near(fast.lateness.runs.mean[i], plain.lateness.runs.mean[i]);
    near(fast.scores.log.value.mean, plain.scores.log.value.mean);
    near(fast.scores.energy.value.mean, plain.scores.energy.value.mean);
    ASSERT_EQ(fast.sensors[0].components.size(), 2U);
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_EQ(fast.sensors[0].components[j].count, plain.sensors[0].components[j].count);
      near(fast.sensors[0].components[j].mean, plain.sensors[0].components[j].mean);
      near(fast.sensors[0].pairs.at(j).mean, plain.sensors[0].pairs.at(j).mean);
    }
    near(fast.sensors[0].measurement_share.mean, plain.sensors[0].measurement_share.mean);
    near(fast.sensors[0].run_means.scatter.trace(), plain.sensors[0].run_means.scatter.trace());
    near(fast.sensors[0].lags.of_values().product(1).trace(),
         plain.sensors[0].lags.of_values().product(1).trace());
    near(fast.law.second_moments.along()[2].mean, plain.law.second_moments.along()[2].mean);
    near(fast.study.steps.back()[Quantity::trace_landmarks].mean,
         plain.study.steps.back()[Quantity::trace_landmarks].mean);
    EXPECT_EQ(fast.whole_runs.last_covariance.size(), plain.whole_runs.last_covariance.size());
  }
}

TEST(EvidenceCollector, TakesWhatTheEnginePlaysAndPlaysTheRest) {
  const Scenario scenario = planar();
  const auto experiment = make_experiment(scenario);
  EvidenceCollector collector(*experiment, 70);
  EXPECT_EQ(collector.play(64, 6), experiment->run_chunk(64, 6));      // the second chunk of two
  EXPECT_EQ(collector.play(128, 64), experiment->run_chunk(128, 64));  // beyond
  const Evidence taken = collector.take(70, {.threads = 1}).value();
  const Evidence alone = collect_evidence(*experiment, 70, {.threads = 1}).value();
  EXPECT_EQ(taken.study, alone.study);
  EXPECT_EQ(taken.whole_runs.nees, alone.whole_runs.nees);
  EXPECT_EQ(taken.sensors[0].fit, alone.sensors[0].fit);
}

TEST(EvidenceCollector, SeesInThePassOfTheEngineWhatAVisitShows) {
  const struct {
    const char* world;
    std::vector<std::string> settings;
    bool some_fail;
  } cases[] = {{"localisation", {}, false},
               {"localisation", {"initial.position_std=1e160"}, true},
               {"inertial", {}, false},
               {"pendulum", {}, false},
               {"planar_slam", {}, false},
               {"spatial_slam", {"world.landmarks=20"}, false},
               {"tracking", {"world.sensor=\"range_bearing\""}, false},
               {"tracking", {"world.sensor=\"range_bearing\"", "initial.position_std=1e160"}, true},
               {"monobot", {"noise.student_dof=5", "noise.measurement_delay=1"}, false}};
  for (const auto& [world, settings, some_fail] : cases) {
    SCOPED_TRACE(fmt::format("{} {}", world, fmt::join(settings, " ")));
    const Scenario scenario = load_scenario_text(
        fmt::format("[world]\nmodel = \"{}\"\n[study]\nsteps = 12\n", world), "t.toml", settings);
    const auto experiment = make_experiment(scenario);
    ASSERT_TRUE(experiment->shows_as_it_runs());
    EvidenceCollector collector(*experiment, 9);
    const StudyStatistics played = collector.play(0, 9);
    EXPECT_EQ(played, experiment->run_chunk(0, 9));
    EXPECT_EQ(!played.failures.empty(), some_fail);
    const Evidence seen = collector.take(9, {.threads = 1}).value();
    const Evidence visited = collect_evidence(AnotherWay(*experiment, true), 9, {.threads = 1}).value();
    ASSERT_EQ(seen.rows, visited.rows);
    EXPECT_EQ(seen.study, visited.study);
    EXPECT_EQ(seen.whole_runs.nees, visited.whole_runs.nees);
    ASSERT_EQ(seen.sensors.size(), visited.sensors.size());
    for (std::size_t i = 0; i < seen.sensors.size(); ++i) {
      EXPECT_EQ(seen.sensors[i].fit, visited.sensors[i].fit);
      EXPECT_EQ(seen.sensors[i].run_means.scatter, visited.sensors[i].run_means.scatter);
    }
    ASSERT_EQ(seen.blocks.size(), visited.blocks.size());
    for (std::size_t b = 0; b < seen.blocks.size(); ++b)
      EXPECT_EQ(seen.blocks[b].nees, visited.blocks[b].nees);
  }
}

TEST(CollectedEvidence, NamesAWrongMeasurementNoiseAndTheFactorThatMendsIt) {
  Scenario scenario = monobot(320);
  scenario.filter.measurement_scale = 0.5;
  const Judgement judgement = analysed(scenario).judgement.value();
  EXPECT_TRUE(names(judgement, Cause::measurement_noise_too_small));
  EXPECT_LT(test_of(judgement, "whiteness of the innovation").adjusted, 1e-6);
  EXPECT_LT(test_of(judgement, "NIS against its law, tails").adjusted, 1e-6);
  EXPECT_GT(judgement.scale_innovation.lower, 1.0);
  EXPECT_GT(judgement.scale_covariance.lower, 1.0);
  // Twice the assumed R is the truth; the advice is of first order.
  EXPECT_GT(judgement.scale_measurement_noise.factor, 1.5);
  EXPECT_LT(judgement.scale_measurement_noise.factor, 2.5);
}

TEST(CollectedEvidence, TellsQFromRInThePlane) {
  // S is mostly R there, so that a wrong Q correlates the innovations by some hundredths only.
  const struct {
    double process, measurement;
    Cause cause;
  } cases[] = {{5.0, 1.0, Cause::process_noise_too_large},
               {0.2, 1.0, Cause::process_noise_too_small},
               {1.0, 2.0, Cause::measurement_noise_too_large},
               {1.0, 0.5, Cause::measurement_noise_too_small}};
  for (const auto& [process, measurement, cause] : cases) {
    Scenario scenario = planar();
    scenario.study.steps = 120;
    scenario.filter.process_scale = process;
    scenario.filter.measurement_scale = measurement;
    const Judgement judgement = analysed(scenario).judgement.value();
    ASSERT_FALSE(judgement.causes.empty()) << process << " " << measurement;
    EXPECT_EQ(judgement.causes.front().cause, cause) << process << " " << measurement;
  }
}

TEST(CollectedEvidence, FindsTheBlocksOfThePlane) {
  const Judgement judgement = analysed(planar()).judgement.value();
  ASSERT_EQ(judgement.blocks.size(), 3U + 6U + 1U);
  EXPECT_EQ(judgement.blocks[0].name, "pose");
  EXPECT_NEAR(judgement.blocks[0].verdict.expected, 3.0, 1e-12);
  EXPECT_NEAR(judgement.blocks[1].verdict.expected, 2.0, 1e-12);
  EXPECT_NEAR(judgement.blocks[2].verdict.expected, 1.0, 1e-12);
  EXPECT_NEAR(judgement.blocks[3].verdict.expected, 2.0, 1e-12);
  EXPECT_EQ(judgement.blocks.back().name, "all landmarks");
}

TEST(CollectedEvidence, NamesTheLinearisationWhereOnlyTheErrorsAreWrong) {
  Scenario scenario = planar();
  scenario.world.landmarks = 10;
  scenario.study.steps = 250;
  const StudyAnalysis analysis = analysed(scenario);
  ASSERT_EQ(analysis.nees.verdict, Verdict::optimistic);
  ASSERT_EQ(analysis.nis.verdict, Verdict::consistent);
  EXPECT_TRUE(names(*analysis.judgement, Cause::linearisation));
}

TEST(CollectedEvidence, CountsCoverageAgainstItsLaw) {
  const Judgement judgement = analysed(monobot(320)).judgement.value();
  // Three states: P(χ²(3) ≤ k²), tables of the χ² law.
  EXPECT_NEAR(judgement.coverage[0].expected, 0.198748, 1e-6);
  EXPECT_NEAR(judgement.coverage[1].expected, 0.738536, 1e-6);
  EXPECT_NEAR(judgement.coverage[2].expected, 0.970709, 1e-6);
  EXPECT_EQ(judgement.coverage[0].pooled.total, 320 * 60);
}

/// One state, whose runs fail at their third step.
class FailingExperiment final : public Experiment {
 public:
  FailingExperiment()
      : Experiment({.states = {"x"}, .angles = {false}, .blocks = {{"x", Part::other, {0}}}}) {}
  StudyStatistics run_chunk(std::int64_t, std::int64_t) const override { return {}; }
  Outcome visit(std::int64_t, const StepVisitor& take) const override {
    for (std::int64_t k = 0; k <= 3; ++k) {
      TraceStep step;
      step.step = k;
      step.states = {0};
      step.error = Vector::Ones(1);
      step.P = Matrix::Identity(1, 1);
      step.innovations.clear();
      if (k == 3) step.outcome = Outcome::diverged;
      take(step);
    }
    return Outcome::diverged;
  }
  RunTrace describe_world() const override { return {}; }
};

TEST(CollectedEvidence, LeavesOutAStepThatFailed) {
  const Evidence s = collect_evidence(FailingExperiment(), 2, {.threads = 1}).value();
  EXPECT_EQ(s.study.runs, 2);
  EXPECT_EQ(s.rows, 4);
  EXPECT_EQ(s.blocks[0].nees[1].value.count, 2);
  EXPECT_EQ(s.blocks[0].nees.size(), 2U);
  EXPECT_TRUE(s.whole_runs.nees.empty());
  EXPECT_EQ(s.study.failures,
            (std::vector<RunFailure>{{0, 3, Outcome::diverged}, {1, 3, Outcome::diverged}}));
  EXPECT_EQ(judge(s).runs, 2);
}

TEST(CollectedEvidence, StopsWhenAsked) {
  const Scenario scenario = monobot(320);
  const std::atomic<bool> stop = true;
  EXPECT_FALSE(collect_evidence(*make_experiment(scenario), 320, {.threads = 2, .stop = &stop}).has_value());
}

// What was played is judged as it would be later: an interruption takes nothing from it.
TEST(CollectedEvidence, AStopTakesNothingFromWhatWasPlayed) {
  const auto experiment = make_experiment(monobot(128));
  const std::atomic<bool> stop = true;
  EvidenceCollector stopped(*experiment, 128), whole(*experiment, 128);
  for (EvidenceCollector* collector : {&stopped, &whole}) {
    collector->play(0, kChunkRuns);
    collector->play(kChunkRuns, kChunkRuns);
  }
  const std::optional<Evidence> found = stopped.take(2 * kChunkRuns, {.threads = 2, .stop = &stop});
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(to_bytes(*found), to_bytes(whole.take(2 * kChunkRuns).value()));
}

TEST(CollectedEvidence, LooksAtNoMoreRunsThanItCanAfford) {
  EXPECT_EQ(evidence_runs(3, 100, 1000000), 1024);
  EXPECT_EQ(evidence_runs(3, 100, 17), 17);
  EXPECT_EQ(evidence_runs(301, 100, 1000000) % kChunkRuns, 0);
  EXPECT_LT(evidence_runs(301, 100, 1000000), 1024);
}

}  // namespace
}  // namespace credence::internal
