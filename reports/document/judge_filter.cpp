#include "reports/document/judge_filter.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/evidence/evidence_collect.h"

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
  JudgedFilter judged(options.name, fmt::format("simulated, {} steps, seed {}", options.steps, options.seed),
                      std::move(evidence).value(),
                      {.confidence = options.confidence, .inflated = options.inflated});
  for (const RunFailure& failure : judged.evidence().study.failures) {
    if (failure.outcome != Outcome::threw || !said) continue;
    judged.explain_failure(failure.run, fmt::format("seed {}: {}", options.seed, said(failure.run)));
  }
  return judged;
}

}  // namespace credence
