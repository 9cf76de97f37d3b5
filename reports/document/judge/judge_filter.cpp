#include "reports/document/judge/judge_filter.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/evidence/sums/evidence_collect.h"
#include "datasets/logs/conventions/log_conventions.h"
#include "montecarlo/worlds/plugged/function_bound.h"
#include "reports/document/judge/judged.h"

namespace credence::internal {
namespace {

/// What logs of the first runs would be told of mistakes in their numbers (LogConventions), of as many rows
/// as it looks at.
Said mistakes_of(const Experiment& experiment, std::int64_t runs, std::int64_t steps) {
  constexpr std::int64_t kRows = 4096;
  Said said;
  SaidSink sink(said);
  LogConventions conventions(sink);
  for (std::int64_t run = 0; run < runs && run * steps < kRows; ++run) {
    conventions.sink().begin_run(experiment.layout());
    experiment.visit(run, [&](const TraceStep& step) {
      if (step.step > 0 && step.outcome == Outcome::ok) conventions.sink().add(step);
    });
  }
  conventions.finish();
  return said;
}

/// Plays all runs and judges them, without a bound.
CheckedLogs played(const Experiment& experiment, const JudgeOptions& options,
                   const std::function<std::string(std::int64_t)>& said) {
  const EngineOptions engine = engine_options(options.threads, options.stop, options.progress);
  EvidenceCollector collector(experiment, options.runs);
  std::optional<Evidence> evidence = collector.take(options.runs, engine);
  const bool complete = evidence.has_value();
  if (!complete) evidence = collector.take(collector.first_runs());
  if (evidence.value().study.runs == 0) {
    throw std::runtime_error("interrupted before the first runs were done");
  }
  if (options.inflated) evidence.value().layout.inflated = true;
  CheckedLogs logs;
  logs.name = options.name;
  logs.format = fmt::format("simulated, {} steps, seed {}", options.steps, options.seed);
  logs.analysis = analyse_logs(std::move(evidence).value(),
                               {.confidence = options.confidence, .times = StepTimes::every(options.dt)});
  logs.analysis.complete = complete;
  if (!complete) return logs;
  Judgement& judgement = logs.analysis.judgement;
  if (is_inconsistent(judgement.word.verdict) || !judgement.causes.empty()) {
    logs.mistakes = mistakes_told(mistakes_of(experiment, options.runs, options.steps), judgement);
    if (!logs.mistakes.empty()) drop_explained_causes(judgement);
  }
  for (const RunFailure& failure : logs.analysis.evidence.study.failures) {
    if (failure.outcome != Outcome::threw || !said) continue;
    logs.failures_said[failure.run] = fmt::format("seed {}: {}", options.seed, said(failure.run));
  }
  return logs;
}

}  // namespace

void require_accepted(const JudgeOptions& options) {
  constexpr std::int64_t kMostRuns = 1'000'000'000, kMostSteps = 10'000'000;  // as study.runs, study.steps
  if (options.runs < 1 || options.runs > kMostRuns || options.steps < 1 || options.steps > kMostSteps) {
    throw std::invalid_argument(fmt::format("{} runs of {} steps: expected 1 to {} runs of 1 to {} steps",
                                            options.runs, options.steps, kMostRuns, kMostSteps));
  }
  const auto refuse = [](const char* option, const auto& value, std::string_view expected) {
    throw std::invalid_argument(fmt::format("{} = {}: expected {}", option, value, expected));
  };
  if (!(options.confidence >= kLeastConfidence && options.confidence <= kMostConfidence))
    refuse("confidence", options.confidence,
           fmt::format("a number from {} to {}", kLeastConfidence, kMostConfidence));
  if (!(options.dt >= 0.0 && std::isfinite(options.dt)))
    refuse("dt", options.dt, "a finite number from 0 on");
  if (options.measurement_delay < 0)
    refuse("measurement_delay", options.measurement_delay, "a number from 0 on");
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

JudgedFilter judge_experiment(const Experiment& experiment, const JudgeOptions& options,
                              const std::function<std::string(std::int64_t)>& said) {
  require_accepted(options);
  return JudgedFilter(judged_logs(played(experiment, options, said)));
}

JudgedFilter judge_model(const FunctionModel& truth, const FunctionModel& believed,
                         const JudgeOptions& options) {
  require_accepted(options);
  const auto require_same = [](const char* what, Index of_filter, Index of_world) {
    if (of_filter != of_world)
      throw std::invalid_argument(fmt::format("{} of the filter has {} rows: expected {}, as in the world",
                                              what, of_filter, of_world));
  };
  require_same("mean", believed.mean.size(), truth.mean.size());
  require_same("R", believed.R.rows(), truth.R.rows());
  const auto make_filter = [&] { return FunctionEkf(believed); };
  const PluggedExperiment experiment(FunctionWorld(truth), make_filter, options.plug());
  if (options.check_plug) require_sound(experiment.problems());
  CheckedLogs logs = played(experiment, options, [&](std::int64_t run) { return experiment.said(run); });
  const bool plain = options.process_noise.is_plain() && options.measurement_noise.is_plain();
  LogAnalysis& a = logs.analysis;
  if (a.complete && plain && options.measurement_delay == 0) {
    a.bound = posterior_bound(truth, options.plug());
    add_bound(*a.bound, a.evidence.study, a.judgement.nees.confidence, a.judgement.accuracy);
  }
  return JudgedFilter(judged_logs(std::move(logs)));
}

}  // namespace credence
