#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {

enum class SweepMode {
  grid,  ///< every value with every other
  zip,   ///< the first values together, the second together, …
};

std::string_view to_string(SweepMode mode);

/// A key that is swept, and its values: sorted for a grid, one for each point as written for zip.
struct SweepAxis {
  std::string path;  ///< section.key
  std::vector<ScalarValue> values;
};

/// One configuration of a sweep.
struct SweepPoint {
  std::string id;                   ///< configuration_id of the scenario
  std::vector<ScalarValue> values;  ///< of each axis
  Scenario scenario;
};

/// All configurations of a sweep, each once, in an order that depends on the configurations alone: axes in
/// the order of the table of keys, points ascending by value, words in the order in which they are
/// documented.
struct SweepPlan {
  std::string name;
  SweepMode mode = SweepMode::grid;
  bool skip_impossible = false;
  std::vector<SweepAxis> axes;
  std::vector<SweepPoint> points;
  std::size_t skipped = 0;  ///< impossible points left out, with skip_impossible
};

/// Plans the [sweep] table of a document over its other settings; without one, its single configuration.
///
/// Throws ScenarioError for unknown and repeated keys, malformed lists, zip of different lengths, more than
/// kLargestSweep points, study.runs or study.confidence (they make no other configuration), and a point that
/// is no valid scenario, which it names. With `skip_impossible = true` points whose values, each accepted,
/// exclude each other are left out and counted.
SweepPlan plan_sweep(const ScenarioDocument& document);

/// The plan as TOML in one fixed form: settings that all points share, then the axes. Planning it again gives
/// the same points.
std::string canonical_toml(const SweepPlan& plan);

/// "world.landmarks = 3, filter.inflation = \"map\"", for messages and tables.
std::string point_text(const SweepPlan& plan, const SweepPoint& point);

}  // namespace credence::internal
