#pragma once

#include <filesystem>
#include <string>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_io.h"
#include "reports/document/document.h"
#include "reports/document/judge/judge_scenario.h"

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
Told run_scenario(const Scenario& scenario, const PlayOptions& options);

/// Runs all configurations of a sweep as `credence sweep` does. It has no single verdict.
Told run_sweep(const ScenarioDocument& document, const PlayOptions& options);

/// What `credence run` or `credence sweep` has stored in a folder so far; nothing is run but what explains
/// the verdict of a single study, as `credence show` does. Throws StoreError.
Told load_stored(const std::filesystem::path& directory, const PlayOptions& options);

/// Tunes a scenario as `credence tune` does; free: as its --free. The verdict is that on fresh noise, empty
/// where nothing could be told. Progress is first of plays of the runs, of an unknown total (0), then of the
/// runs with fresh noise.
Told tune(const Scenario& scenario, const std::string& free, const PlayOptions& options);

}  // namespace credence::internal
