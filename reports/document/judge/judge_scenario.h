#pragma once

#include <atomic>

#include "montecarlo/scenario/scenario.h"
#include "reports/document/judge/judged_filter.h"

namespace credence {

/// How a scenario is played; the bits do not depend on it.
struct PlayOptions {
  int threads = 0;                          ///< 0: one for each processor
  const std::atomic<bool>* stop = nullptr;  ///< set: what was played until then is judged
  JudgeProgress progress{};                 ///< of the runs
};

/// Runs a scenario and judges its filter as `credence run` does.
///
/// Throws ScenarioError for a value that no scenario file may have, std::invalid_argument where its world
/// cannot be made, and std::runtime_error where it was stopped before the first runs were done.
JudgedFilter judge_scenario(const Scenario& scenario, const PlayOptions& options = {});

}  // namespace credence
