#include "reports/document/judge_filter.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/evidence/evidence_collect.h"
#include "montecarlo/worlds/plugged/function_bound.h"

namespace credence {

JudgedFilter judge_experiment(const Experiment& experiment, const JudgeOptions& options,
                              const std::function<std::string(std::int64_t)>& said) {
  if (options.runs < 1 || options.steps < 1) {
    throw std::invalid_argument(
        fmt::format("{} runs of {} steps: expected at least 1", options.runs, options.steps));
  }
  EngineOptions engine;
  engine.threads = options.threads;
  std::optional<Evidence> evidence = collect_evidence(experiment, options.runs, engine);
  if (options.inflated) evidence.value().layout.inflated = true;
  JudgedFilter judged(options.name, fmt::format("simulated, {} steps, seed {}", options.steps, options.seed),
                      std::move(evidence).value(), {.confidence = options.confidence});
  for (const RunFailure& failure : judged.evidence().study.failures) {
    if (failure.outcome != Outcome::threw || !said) continue;
    judged.explain_failure(failure.run, fmt::format("seed {}: {}", options.seed, said(failure.run)));
  }
  return judged;
}

JudgedFilter judge_model(const FunctionModel& truth, const FunctionModel& believed,
                         const JudgeOptions& options) {
  JudgedFilter judged = judge_filter(
      FunctionWorld(truth), [&] { return FunctionEkf(believed); }, options);
  const bool plain = options.process_noise.is_plain() && options.measurement_noise.is_plain();
  if (plain && options.measurement_delay == 0) judged.set_bound(posterior_bound(truth, options.plug()));
  return judged;
}

}  // namespace credence
