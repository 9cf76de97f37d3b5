#include "reports/document/judge_scenario.h"

#include "reports/document/judge_study.h"

namespace credence {

JudgedFilter judge_scenario(const Scenario& scenario, const PlayOptions& options) {
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = options.stop;
  return judge_study(scenario, engine, engine);
}

}  // namespace credence
