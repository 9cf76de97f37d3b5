#include "montecarlo/scenario/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "montecarlo/scenario/scenario_resolve.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan_axes.h"

namespace credence::internal {
namespace {

struct Options {
  SweepMode mode = SweepMode::grid;
  bool skip_impossible = false;
};

/// A scalar as a word: a flag is text on the command line and a boolean in a file. Empty for all else.
std::string_view word_of(const Setting& setting) {
  const auto* scalar = std::get_if<ScalarValue>(&setting.value);
  if (scalar == nullptr) return {};
  if (const auto* text = std::get_if<std::string>(scalar)) return *text;
  const auto* flag = std::get_if<bool>(scalar);
  return flag == nullptr ? "" : *flag ? "true" : "false";
}

void read_option(const Setting& setting, Options& options) {
  const std::string_view word = word_of(setting);
  if (setting.key == "mode") {
    if (word != "grid" && word != "zip") {
      throw ScenarioError(fmt::format("{}: must be one of \"grid\", \"zip\"", setting.place));
    }
    options.mode = word == "zip" ? SweepMode::zip : SweepMode::grid;
  } else if (setting.key == "skip_impossible") {
    if (word != "true" && word != "false") {
      throw ScenarioError(fmt::format("{}: must be true or false", setting.place));
    }
    options.skip_impossible = word == "true";
  } else {
    throw ScenarioError(fmt::format(
        "{}: unknown key; [sweep] accepts mode, skip_impossible, and section.key such as world.landmarks",
        setting.place));
  }
}

/// The document's settings that no axis replaces.
std::vector<Setting> unswept(const ScenarioDocument& document, const std::vector<Axis>& axes) {
  std::vector<Setting> settings;
  for (const Setting& setting : document.settings) {
    const bool swept = std::any_of(axes.begin(), axes.end(), [&](const Axis& axis) {
      return axis.key->section == setting.section && axis.key->name == setting.key;
    });
    if (!swept) settings.push_back(setting);
  }
  return settings;
}

/// Adds points to a plan, each configuration once.
class PointMaker {
 public:
  PointMaker(SweepPlan& plan, const std::vector<Axis>& axes, std::vector<Setting> settings,
             const std::string& file)
      : plan_(plan),
        axes_(axes),
        settings_(std::move(settings)),
        base_count_(settings_.size()),
        file_(file) {}

  void add(const AxisIndices& indices) {
    SweepPoint point;
    settings_.resize(base_count_);
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      settings_.push_back(axes_[a].values[indices[a]].setting);
      point.values.push_back(axes_[a].values[indices[a]].value());
    }
    const std::optional<Scenario> scenario = resolve(point);
    if (!scenario) return;
    point.scenario = *scenario;
    point.scenario.name = plan_.name;
    point.id = configuration_id(point.scenario);
    const auto [known, is_new] = by_id_.emplace(point.id, plan_.points.size());
    if (is_new) {
      plan_.points.push_back(std::move(point));
    } else if (plan_.points[known->second].scenario != point.scenario) {
      throw ScenarioError(fmt::format("{}: two configurations share the identity {}: {} and {}; take one out",
                                      file_, point.id, point_text(plan_, plan_.points[known->second]),
                                      point_text(plan_, point)));
    }
  }

 private:
  std::optional<Scenario> resolve(const SweepPoint& point) {
    try {
      return resolve_scenario(settings_, file_);
    } catch (const ImpossibleCombination& error) {
      if (!plan_.skip_impossible) {
        if (axes_.empty()) throw;
        throw ScenarioError(
            fmt::format("{} (sweep point {}; skip_impossible = true in [sweep] leaves such out)",
                        error.what(), point_text(plan_, point)));
      }
      ++plan_.skipped;
      return std::nullopt;
    } catch (const ScenarioError& error) {
      if (axes_.empty()) throw;
      throw ScenarioError(fmt::format("{} (sweep point {})", error.what(), point_text(plan_, point)));
    }
  }

  SweepPlan& plan_;
  const std::vector<Axis>& axes_;
  std::vector<Setting> settings_;
  std::size_t base_count_;
  const std::string& file_;
  std::unordered_map<std::string, std::size_t> by_id_;
};

std::string list_text(const std::vector<ScalarValue>& values) {
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const ScalarValue& value : values) texts.push_back(value_text(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

bool is_swept(const SweepPlan& plan, const ScenarioKey& key) {
  return std::any_of(plan.axes.begin(), plan.axes.end(),
                     [&](const SweepAxis& axis) { return axis.path == key.path(); });
}

/// Every point of the sweep sets this key: what a user sets would do nothing.
void refuse_override(const Setting& swept, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) {
    if (setting.section != swept.section || setting.key != swept.key || !setting.place.starts_with("--set "))
      continue;
    throw ScenarioError(
        fmt::format("{}: the sweep varies this key ({}); --set sweep.{}.{}=... says over what", setting.place,
                    swept.place, swept.section, swept.key));
  }
}

}  // namespace

std::string_view to_string(SweepMode mode) { return mode == SweepMode::grid ? "grid" : "zip"; }

SweepPlan plan_sweep(const ScenarioDocument& document) {
  Options options;
  std::vector<Axis> axes;
  for (const Setting& setting : document.sweep) {
    if (setting.section.empty()) read_option(setting, options);
  }
  double count = 1.0;
  for (const Setting& setting : document.sweep) {
    if (setting.section.empty()) continue;
    refuse_override(setting, document.settings);
    Axis& axis = axes.emplace_back(make_axis(setting, document.settings));
    if (options.mode != SweepMode::grid) continue;
    sort_values(axis);
    count *= static_cast<double>(axis.values.size());
    check_count(count, document.file);  // before the next list is made
  }
  std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.key < b.key; });
  const std::vector<AxisIndices> points =
      options.mode == SweepMode::grid ? grid_points(axes) : zip_points(axes);

  SweepPlan plan{document.name, options.mode, options.skip_impossible, {}, {}, 0};
  for (const Axis& axis : axes) plan.axes.push_back({axis.key->path(), {}});
  PointMaker maker(plan, axes, unswept(document, axes), document.file);
  for (const AxisIndices& point : points) maker.add(point);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const bool is_zip = options.mode == SweepMode::zip;
    for (std::size_t i = 0; i < axes[a].values.size(); ++i) {
      const std::size_t at = is_zip ? points[i][a] : i;
      plan.axes[a].values.push_back(axes[a].values[at].value());
    }
  }
  if (plan.points.empty()) {
    throw ScenarioError(
        fmt::format("{}: [sweep] has no possible point: all {} were skipped", document.file, plan.skipped));
  }
  return plan;
}

std::string canonical_toml(const SweepPlan& plan) {
  std::string text;
  std::string_view section;
  for (const ScenarioKey& key : scenario_keys()) {
    if (is_swept(plan, key)) continue;
    const auto user = std::find_if(plan.points.begin(), plan.points.end(),
                                   [&](const SweepPoint& point) { return key.in_effect_in(point.scenario); });
    if (user == plan.points.end()) continue;
    if (key.section != section) {
      section = key.section;
      text += fmt::format("[{}]\n", section);
    }
    text += fmt::format("{} = {}\n", key.name, full_text(key_value(key, user->scenario)));
  }
  if (plan.axes.empty()) return text;
  text += fmt::format("[sweep]\nmode = \"{}\"\n", to_string(plan.mode));
  if (plan.skip_impossible) text += "skip_impossible = true\n";
  for (const SweepAxis& axis : plan.axes) text += fmt::format("{} = {}\n", axis.path, list_text(axis.values));
  return text;
}

std::string point_text(const SweepPlan& plan, const SweepPoint& point) {
  std::vector<std::string> parts;
  for (std::size_t a = 0; a < plan.axes.size() && a < point.values.size(); ++a) {
    parts.push_back(fmt::format("{} = {}", plan.axes[a].path, value_text(point.values[a])));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace credence::internal
