#include "montecarlo/scenario/sweep_plan_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "montecarlo/scenario/scenario_resolve.h"
#include "montecarlo/scenario/sweep_plan_values.h"

namespace credence::internal {
namespace {

long double rank_of(const ScenarioKey& key, const Scenario& scenario) {
  if (const auto* real = std::get_if<RealField>(&key.field)) return real->get(scenario);
  if (const auto* integer = std::get_if<IntegerField>(&key.field)) {
    return static_cast<long double>(integer->get(scenario));
  }
  return static_cast<long double>(std::get<ChoiceField>(key.field).get(scenario));
}

std::vector<ScalarValue> expand(const Setting& setting) {
  std::vector<ScalarValue> written;
  if (const auto* scalar = std::get_if<ScalarValue>(&setting.value)) {
    written.push_back(*scalar);
  } else if (const auto* list = std::get_if<std::vector<ScalarValue>>(&setting.value)) {
    written = *list;
  } else {
    written.emplace_back(OtherValue{"an array"});
  }
  std::vector<ScalarValue> values;
  try {
    for (const ScalarValue& value : written) {
      const auto* text = std::get_if<std::string>(&value);
      const std::vector<ScalarValue> more = text == nullptr ? std::vector{value} : expand_sweep_list(*text);
      values.insert(values.end(), more.begin(), more.end());
    }
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(fmt::format("{}: {}", setting.place, error.what()));
  }
  if (values.empty()) throw ScenarioError(fmt::format("{}: must name at least one value", setting.place));
  return values;
}

/// The place of one value, which is that of its list with the value beside it.
std::string value_place(const Setting& setting, const ScalarValue& value) {
  return fmt::format("{}, value {}", setting.place, value_text(value));
}

}  // namespace

void check_count(double count, const std::string& file) {
  if (count > static_cast<double>(kLargestSweep)) {
    throw ScenarioError(fmt::format("{}: [sweep] has {:.0f} points or more; at most {} are accepted", file,
                                    count, kLargestSweep));
  }
}

Axis make_axis(const Setting& setting, std::span<const Setting> settings) {
  Axis axis{find_scenario_key(setting.section, setting.key), setting.place, {}};
  if (axis.key == nullptr) throw_unknown_key(setting, settings);
  const std::string path = axis.key->path();
  if (path == "study.runs" || path == "study.confidence" || axis.key->section == "study.stop") {
    throw ScenarioError(
        fmt::format("{}: cannot be swept, since it makes no other configuration; set it once in "
                    "[study]",
                    setting.place));
  }
  if (std::holds_alternative<RowsField>(axis.key->field) ||
      std::holds_alternative<NamesField>(axis.key->field)) {
    throw ScenarioError(
        fmt::format("{}: cannot be swept, since it is an array; numbers and words can", setting.place));
  }
  Scenario scratch;
  for (const ScalarValue& value : expand(setting)) {
    std::string place = value_place(setting, value);
    const std::string wrong = set_key(*axis.key, value, scratch);
    if (!wrong.empty()) throw ScenarioError(fmt::format("{}: {}", place, wrong));
    // Read back, so that 1 and 1.0 are one value of a real key.
    axis.values.push_back({rank_of(*axis.key, scratch),
                           {setting.section, setting.key, key_value(*axis.key, scratch), std::move(place)}});
  }
  return axis;
}

void sort_values(Axis& axis) {
  std::stable_sort(axis.values.begin(), axis.values.end(),
                   [](const AxisValue& a, const AxisValue& b) { return a.rank < b.rank; });
  const auto last =
      std::unique(axis.values.begin(), axis.values.end(),
                  [](const AxisValue& a, const AxisValue& b) { return a.value() == b.value(); });
  axis.values.erase(last, axis.values.end());
}

std::vector<AxisIndices> grid_points(const std::vector<Axis>& axes) {
  std::size_t count = 1;
  for (const Axis& axis : axes) count *= axis.values.size();
  std::vector<AxisIndices> points;
  AxisIndices point(axes.size(), 0);
  for (std::size_t left = count; left > 0; --left) {
    points.push_back(point);
    for (std::size_t a = axes.size(); a-- > 0;) {
      if (++point[a] < axes[a].values.size()) break;
      point[a] = 0;
    }
  }
  return points;
}

std::vector<AxisIndices> zip_points(const std::vector<Axis>& axes) {
  std::vector<AxisIndices> points;
  if (axes.empty()) return {AxisIndices{}};
  const std::size_t count = axes.front().values.size();
  for (const Axis& axis : axes) {
    if (axis.values.size() == count) continue;
    throw ScenarioError(
        fmt::format("{}: has {} values, but {} has {}; with mode = \"zip\" all lists must be of "
                    "one length",
                    axis.place, axis.values.size(), axes.front().key->path(), count));
  }
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(axes.size(), i);
  std::stable_sort(points.begin(), points.end(), [&](const AxisIndices& a, const AxisIndices& b) {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      const long double left = axes[axis].values[a[axis]].rank, right = axes[axis].values[b[axis]].rank;
      if (left != right) return left < right;
    }
    return false;
  });
  return points;
}

}  // namespace credence::internal
