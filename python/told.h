#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_io.h"
#include "reports/document/document.h"
#include "reports/document/judge/judged_filter.h"

namespace credence::internal {

/// What is told of a judged filter, wherever its runs came from.
struct Told {
  std::string verdict, says;
  double p_value = 0.0;
  bool complete = true;
  bool is_sweep = false;
  std::string tuned{};  ///< of a tuning: the tuned scenario as TOML, "" where there is none
  Document document{};
};

Told tell(const JudgedFilter& filter);

/// Runs a scenario as `credence run` does.
Told run_scenario(const Scenario& scenario, int threads, const std::atomic<bool>& stop);

/// Runs all configurations of a sweep as `credence sweep` does. It has no single verdict.
Told run_sweep(const ScenarioDocument& document, int threads, const std::atomic<bool>& stop);

/// What `credence run` or `credence sweep` has stored in a folder so far; nothing is run but what explains
/// the verdict of a single study, as `credence show` does. Throws StoreError.
Told load_stored(const std::filesystem::path& directory, int threads, const std::atomic<bool>& stop);

/// Tunes a scenario as `credence tune` does; free: as its --free. The verdict is that on fresh noise, empty
/// where nothing could be told.
Told tune(const Scenario& scenario, const std::string& free, int threads, const std::atomic<bool>& stop);

}  // namespace credence::internal
