#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/scenario_value.h"

/// @file
/// The axes of a sweep before they are combined: what the lists of the [sweep] table hold.

namespace credence::internal {

/// One value of an axis: what sorts it, and the setting that it makes.
struct AxisValue {
  long double rank = 0.0L;  ///< the number itself (a seed has 63 bits), or the index of the word
  Setting setting;          ///< its value is a scalar

  const ScalarValue& value() const { return std::get<ScalarValue>(setting.value); }
};

struct Axis {
  const ScenarioKey* key = nullptr;
  std::string place;  ///< of its list, for messages
  std::vector<AxisValue> values;
};

/// A point of a sweep: the index of its value on each axis.
using AxisIndices = std::vector<std::size_t>;

/// The axis of one entry of the [sweep] table, values as written. `settings` are the document's others.
/// Throws ScenarioError for an unknown key, a malformed list, a value that the key does not accept, and keys
/// that make no other configuration.
Axis make_axis(const Setting& entry, std::span<const Setting> settings);

/// Ascending, each value once.
void sort_values(Axis& axis);

/// Throws ScenarioError for more than kLargestSweep points; `file` is for the message.
void check_count(double count, const std::string& file);

/// All combinations, the last axis fastest.
std::vector<AxisIndices> grid_points(const std::vector<Axis>& axes);

/// The first values of all axes, the second, …, sorted by value. Throws ScenarioError for axes of different
/// lengths.
std::vector<AxisIndices> zip_points(const std::vector<Axis>& axes);

}  // namespace credence::internal
