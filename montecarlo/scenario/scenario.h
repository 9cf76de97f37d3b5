#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/inflation/inflation.h"
#include "core/inflation/rank_inflation.h"
#include "core/models/vehicle.h"
#include "core/record/block_layout.h"
#include "core/types.h"

/// @file
/// What one configuration of a study is: the world, its noise, the filter that is judged, and how it is run.
/// The meaning, unit, default and accepted values of every field are in the table of scenario_schema.h and in
/// docs/scenario.md; scenario_io.h reads these structs from a TOML file.

namespace credence::internal {

/// What a confidence may be: below the least a verdict says little, and above the most the tails that tests
/// share end where 1 − confidence has no digits left.
inline constexpr double kLeastConfidence = 0.5, kMostConfidence = 0.999999;

}  // namespace credence::internal

namespace credence {

/// Whether known landmarks make the whole state observable (world.observability).
enum class Observability {
  partial,  ///< every landmark is a state
  full,     ///< `anchors` more landmarks stand at known positions and are no states
};
/// The path of a planar vehicle (world.path).
enum class PathShape { circle, eight, line };

/// The covariance inflation of the filter: those of core/inflation/inflation.h, and a constant ΔP of given
/// rank.
enum class FilterInflation { none, full, map, rank };

/// The table [world].
struct WorldSettings {
  std::string model = "monobot";  ///< name of one of the worlds of world_schema.h
  Index landmarks = 2;            ///< N, landmarks that are states
  Observability observability = Observability::partial;
  Index anchors = 0;  ///< known landmarks that are no states; 0 when partial
  VehicleKind vehicle = VehicleKind::unicycle;
  PathShape path = PathShape::circle;
  double path_radius = 10.0;         ///< m; of the line, half its length
  double speed = 1.0;                ///< m/s
  double dt = 1.0;                   ///< s; one step of the monobot is 1, the planar default is 0.25
  double sensor_min_range = 1.0;     ///< m; at close quarters a bearing says nothing linear
  double sensor_range = 30.0;        ///< m
  double field_of_view_deg = 360.0;  ///< full angle, centred on the heading

  bool operator==(const WorldSettings&) const = default;
};

/// The table [noise].
struct NoiseSettings {
  double process_variance = 0.1;       ///< m² a step, monobot
  double measurement_variance = 0.1;   ///< m², monobot
  double initial_variance = 1.0;       ///< m², of every state, monobot
  double speed_std = 0.1;              ///< m/s, planar
  double turn_rate_std = 0.05;         ///< rad/s, planar unicycle
  double steering_std_deg = 3.0;       ///< planar bicycle and car
  double range_std = 0.1;              ///< m, planar
  double bearing_std_deg = 1.0;        ///< planar
  double detection_probability = 1.0;  ///< of every landmark in view at every step, independently

  bool operator==(const NoiseSettings&) const = default;
};

/// Spread of the initial pose of a planar vehicle.
struct InitialSettings {
  double position_std = 0.05;    ///< m, each of x and y
  double heading_std_deg = 1.0;  ///< deg

  bool operator==(const InitialSettings&) const = default;
};

/// The table [filter].
struct FilterSettings {
  FilterInflation inflation = FilterInflation::none;
  InflationSolution solution = InflationSolution::pairwise;  ///< of full and map
  double process_scale = 1.0;                                ///< assumed / true process variance
  double measurement_scale = 1.0;                            ///< assumed / true measurement variance
  Index inflation_rank = 1;                                  ///< rank ΔP, of rank
  InflationRange inflation_range = InflationRange::generic;  ///< of rank
  double inflation_scale = 1.0;  ///< m², the non-zero eigenvalues of ΔP, of rank

  bool operator==(const FilterSettings&) const = default;
};

/// The table [study].
struct StudySettings {
  std::int64_t runs = 200;
  std::int64_t steps = 100;
  std::uint64_t seed = 1;
  double confidence = 0.95;  ///< of every interval and verdict

  bool operator==(const StudySettings&) const = default;
};

/// Which verdict may end a study early (study.stop).
enum class StopVerdict {
  none,          ///< the study makes all its runs
  inconsistent,  ///< it ends when the filter is proved inconsistent
  either,        ///< or proved consistent within a factor
};

/// When a study may end before its last run; no part of what is computed in a run.
struct StopSettings {
  StopVerdict verdict = StopVerdict::none;
  double consistent_within = 0.1;  ///< of either: P is right within the factor 1 + this
  double precision = 0.0;          ///< > 0: the mean NEES is known to this relative half-width
  double max_seconds = 0.0;        ///< > 0: time of the study
  std::int64_t max_runs = 0;       ///< > 0: in the place of study.runs

  bool asked() const { return verdict != StopVerdict::none || precision > 0.0; }
  bool operator==(const StopSettings&) const = default;
};

/// Numbers as rows, of lengths that a world has to check.
using NumberRows = std::vector<std::vector<double>>;

/// Values of the keys that a world keeps in its own folder, by section.name; what is not in it has its
/// default.
using OwnValue = std::variant<double, std::int64_t, std::size_t, NumberRows, std::vector<std::string>>;
/// The values of the keys that only some worlds have, by their names.
using OwnValues = std::map<std::string, OwnValue, std::less<>>;

/// One configuration, resolved: every field has its value, fields that play no part have their default.
struct Scenario {
  std::string name;  ///< stem of the file; a label, no part of the configuration's identity
  WorldSettings world;
  NoiseSettings noise;
  InitialSettings initial;
  FilterSettings filter;
  StudySettings study;
  StopSettings stop;
  OwnValues own;

  /// Runs that the study makes unless it may end before.
  std::int64_t most_runs() const { return stop.max_runs > 0 ? stop.max_runs : study.runs; }

  bool operator==(const Scenario&) const = default;
};

/// The word that stands for the value in a scenario file.
std::string_view to_string(Observability value);
std::string_view to_string(VehicleKind value);
std::string_view to_string(PathShape value);
std::string_view to_string(FilterInflation value);
std::string_view to_string(InflationSolution value);
std::string_view to_string(InflationRange value);
std::string_view to_string(StopVerdict value);

/// A scenario that cannot be used: the message names file and line (or the command-line option), the key,
/// its value, and what is accepted.
struct ScenarioError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace credence
