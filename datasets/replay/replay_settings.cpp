#include "datasets/replay/replay_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/filters/estimators/estimators.h"

namespace credence::internal {
namespace {

/// One key: how to write a value and how to show it. `limits` says in words what is accepted.
struct Key {
  std::string name;
  std::string limits;
  std::function<bool(ReplaySettings&, std::string_view)> set;  ///< false: not accepted
  std::function<std::string(const ReplaySettings&)> text;
};

bool parse_number(std::string_view text, double& number) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && stop == text.data() + text.size() && std::isfinite(number);
}

/// A key that holds a number for which `accepts` is true.
Key number_key(std::string name, std::string limits, const std::function<double&(ReplaySettings&)>& field,
               const std::function<bool(double)>& accepts) {
  return {std::move(name), std::move(limits),
          [=](ReplaySettings& settings, std::string_view text) {
            double number = 0;
            if (!parse_number(text, number) || !accepts(number)) return false;
            field(settings) = number;
            return true;
          },
          [=](const ReplaySettings& settings) {
            ReplaySettings copy = settings;
            return fmt::format("{}", field(copy));
          }};
}

template <typename Value>
struct Word {
  std::string_view text;
  Value value;
};

/// A key that holds one of several words.
template <typename Value>
Key word_key(std::string name, std::vector<Word<Value>> words, std::function<Value&(ReplaySettings&)> field) {
  std::string limits = "one of";
  for (const Word<Value>& word : words) limits += fmt::format(" \"{}\"", word.text);
  return {std::move(name), std::move(limits),
          [=](ReplaySettings& settings, std::string_view text) {
            for (const Word<Value>& word : words) {
              if (word.text != text) continue;
              field(settings) = word.value;
              return true;
            }
            return false;
          },
          [=](const ReplaySettings& settings) {
            ReplaySettings copy = settings;
            for (const Word<Value>& word : words)
              if (word.value == field(copy)) return std::string(word.text);
            return std::string();
          }};
}

Key deviation_key(std::string name, const std::function<double&(ReplaySettings&)>& field) {
  return number_key(std::move(name), "a number >= 0", field, [](double x) { return x >= 0; });
}

Key positive_key(std::string name, const std::function<double&(ReplaySettings&)>& field) {
  return number_key(std::move(name), "a number > 0", field, [](double x) { return x > 0; });
}

Key anchors_key() {
  const auto accepts = [](double x) { return x >= 0 && x <= 1000 && x == std::floor(x); };
  return {"world.anchors", "a whole number from 0 to 1000",
          [=](ReplaySettings& settings, std::string_view text) {
            double number = 0;
            if (!parse_number(text, number) || !accepts(number)) return false;
            settings.world.anchors = static_cast<Index>(number);
            return true;
          },
          [](const ReplaySettings& settings) { return std::to_string(settings.world.anchors); }};
}

Key estimator_key() {
  std::vector<Word<std::string>> words;
  for (const EstimatorKind& kind : estimator_kinds()) words.push_back({kind.name, std::string(kind.name)});
  return word_key<std::string>("filter.estimator", std::move(words),
                               [](ReplaySettings& s) -> std::string& { return s.filter.estimator; });
}

std::vector<Key> world_and_filter_keys() {
  using S = ReplaySettings;
  return {
      word_key<bool>("world.observability", {{"partial", false}, {"full", true}},
                     [](S& s) -> bool& { return s.world.full; }),
      anchors_key(),
      word_key<Inflation>("filter.inflation",
                          {{"none", Inflation::none}, {"full", Inflation::full}, {"map", Inflation::map}},
                          [](S& s) -> Inflation& { return s.filter.inflation; }),
      word_key<InflationSolution>("filter.solution",
                                  {{"pairwise", InflationSolution::pairwise},
                                   {"min-trace", InflationSolution::min_trace},
                                   {"sequential", InflationSolution::sequential},
                                   {"batch", InflationSolution::batch}},
                                  [](S& s) -> InflationSolution& { return s.filter.solution; }),
      word_key<ReplayAssociation>(
          "filter.association",
          {{"survey", ReplayAssociation::survey}, {"compatibility", ReplayAssociation::compatibility}},
          [](S& s) -> ReplayAssociation& { return s.filter.association; }),
      number_key(
          "filter.gate", "a probability in [0, 1), 0 for none", [](S& s) -> double& { return s.filter.gate; },
          [](double x) { return x >= 0 && x < 1; }),
      word_key<ReplayJacobians>("filter.jacobians",
                                {{"estimate", ReplayJacobians::estimate}, {"truth", ReplayJacobians::truth}},
                                [](S& s) -> ReplayJacobians& { return s.filter.jacobians; }),
      estimator_key()};
}

std::vector<Key> sensor_keys() {
  using S = ReplaySettings;
  const auto any = [](double) { return true; };
  std::vector<Key> keys;
  keys.push_back(word_key<RangeKind>("sensor.range",
                                     {{"distance", RangeKind::distance}, {"depth", RangeKind::depth}},
                                     [](S& s) -> RangeKind& { return s.sensor.range; }));
  keys.push_back(number_key(
      "sensor.range_offset_m", "a number of metres", [](S& s) -> double& { return s.sensor.range_offset_m; },
      any));
  keys.push_back(positive_key("sensor.range_scale", [](S& s) -> double& { return s.sensor.range_scale; }));
  keys.push_back(number_key(
      "sensor.bearing_offset_deg", "a number of degrees",
      [](S& s) -> double& { return s.sensor.bearing_offset_deg; }, any));
  keys.push_back(number_key(
      "sensor.odometry_delay_s", "a number of seconds within [-10, 10]",
      [](S& s) -> double& { return s.sensor.odometry_delay_s; }, [](double x) { return std::abs(x) <= 10; }));
  keys.push_back(positive_key("sensor.speed_scale", [](S& s) -> double& { return s.sensor.speed_scale; }));
  keys.push_back(positive_key("sensor.turn_scale", [](S& s) -> double& { return s.sensor.turn_scale; }));
  keys.push_back(number_key(
      "sensor.turn_drift_deg_s", "a number of degrees per second",
      [](S& s) -> double& { return s.sensor.turn_drift_deg_s; }, any));
  keys.push_back(deviation_key("truth.position_std", [](S& s) -> double& { return s.truth.position_std; }));
  keys.push_back(
      deviation_key("truth.heading_std_deg", [](S& s) -> double& { return s.truth.heading_std_deg; }));
  return keys;
}

/// Whether a key means something for a vehicle.
bool belongs(const std::string& key, VehicleKind vehicle) {
  const bool unicycle = vehicle == VehicleKind::unicycle;
  static constexpr std::array<std::string_view, 6> kUnicycle = {
      "noise.turn_rate_std", "filter.jacobians",        "sensor.range",
      "sensor.turn_scale",   "sensor.turn_drift_deg_s", "truth.heading_std_deg"};
  if (std::find(kUnicycle.begin(), kUnicycle.end(), key) != kUnicycle.end()) return unicycle;
  if (key == "noise.steering_std_deg" || key == "initial.heading_deg") return !unicycle;
  return true;
}

std::vector<Key> all_keys() {
  using S = ReplaySettings;
  const auto any = [](double) { return true; };
  std::vector<Key> keys = world_and_filter_keys();
  keys.push_back(
      deviation_key("initial.position_std", [](S& s) -> double& { return s.initial.position_std; }));
  keys.push_back(
      deviation_key("initial.heading_std_deg", [](S& s) -> double& { return s.initial.heading_std_deg; }));
  keys.push_back(number_key(
      "initial.heading_deg", "a number of degrees", [](S& s) -> double& { return s.initial.heading_deg; },
      any));
  keys.push_back(deviation_key("noise.speed_std", [](S& s) -> double& { return s.noise.speed_std; }));
  keys.push_back(
      deviation_key("noise.steering_std_deg", [](S& s) -> double& { return s.noise.steering_std_deg; }));
  keys.push_back(deviation_key("noise.turn_rate_std", [](S& s) -> double& { return s.noise.turn_rate_std; }));
  keys.push_back(positive_key("noise.range_std", [](S& s) -> double& { return s.noise.range_std; }));
  keys.push_back(
      positive_key("noise.bearing_std_deg", [](S& s) -> double& { return s.noise.bearing_std_deg; }));
  for (Key& key : sensor_keys()) keys.push_back(std::move(key));
  return keys;
}

}  // namespace

ReplaySettings carpark_settings() { return {}; }

ReplaySettings mrclam_settings(int robot) {
  ReplaySettings settings;
  settings.vehicle = VehicleKind::unicycle;
  settings.initial = {.position_std = 0.01, .heading_std_deg = 1, .heading_deg = 0};
  settings.noise = {.speed_std = 0.15, .steering_std_deg = 0, .turn_rate_std = 0.4};
  settings.noise.range_std = 0.03;
  settings.noise.bearing_std_deg = 0.4;
  settings.filter.gate = 0.999;
  settings.sensor.range = RangeKind::depth;
  settings.sensor.range_offset_m = 0.04;
  settings.sensor.range_scale = 1.014;
  settings.sensor.odometry_delay_s = 0.2;
  settings.sensor.speed_scale = robot == 1 ? 0.913 : robot == 3 ? 0.876 : 0.895;
  settings.sensor.turn_scale = robot == 1 ? 0.946 : robot == 3 ? 0.964 : 0.955;
  settings.sensor.turn_drift_deg_s = robot == 1 ? -0.218 : robot == 3 ? -0.111 : 0;
  settings.truth.position_std = 0.003;
  settings.truth.heading_std_deg = robot == 3 ? 0.2 : 1.2;
  return settings;
}

void set_replay_setting(ReplaySettings& settings, std::string_view key, std::string_view value) {
  std::vector<std::string> names;
  for (const Key& known : all_keys()) {
    if (!belongs(known.name, settings.vehicle)) continue;
    names.push_back(known.name);
    if (known.name != key) continue;
    if (!known.set(settings, value))
      throw std::invalid_argument(fmt::format("{} = {}: must be {}", key, value, known.limits));
    return;
  }
  throw std::invalid_argument(
      fmt::format("unknown key {} for this data set; known are {}", key, fmt::join(names, ", ")));
}

void check_replay_settings(const ReplaySettings& settings) {
  // What can be set by name has passed its limits; a struct filled by hand passes them here.
  ReplaySettings copy = settings;
  for (const ReplaySettingText& entry : replay_settings_text(settings))
    set_replay_setting(copy, entry.key, entry.value);
  if (settings.world.full && settings.world.anchors < 1)
    throw std::invalid_argument("world.anchors must be >= 1 with world.observability = full");
  if (settings.filter.association == ReplayAssociation::compatibility && settings.filter.gate <= 0)
    throw std::invalid_argument("filter.association = compatibility needs a filter.gate, e.g. 0.99");
  if (settings.filter.association == ReplayAssociation::compatibility &&
      settings.filter.jacobians == ReplayJacobians::truth)
    throw std::invalid_argument("filter.jacobians = truth needs filter.association = survey");
  if (settings.filter.estimator == "ekf") return;
  const auto needs_ekf = [&](bool asked, std::string_view what) {
    if (asked)
      throw std::invalid_argument(
          fmt::format("{} needs filter.estimator = ekf, it is {}", what, settings.filter.estimator));
  };
  needs_ekf(settings.world.full, "world.observability = full");
  needs_ekf(settings.filter.inflation != Inflation::none, "filter.inflation");
  needs_ekf(settings.filter.association == ReplayAssociation::compatibility,
            "filter.association = compatibility");
  needs_ekf(settings.filter.jacobians == ReplayJacobians::truth, "filter.jacobians = truth");
}

std::vector<ReplaySettingText> replay_settings_text(const ReplaySettings& settings) {
  std::vector<ReplaySettingText> result;
  for (const Key& key : all_keys())
    if (belongs(key.name, settings.vehicle)) result.push_back({key.name, key.text(settings)});
  return result;
}

}  // namespace credence::internal
