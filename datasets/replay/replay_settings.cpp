#include "datasets/replay/replay_settings.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "core/filters/estimators/estimators.h"
#include "datasets/logs/number_field.h"

namespace credence::internal {
namespace {

using S = ReplaySettings;

/// The numbers that a key accepts, in words and as a test.
struct Limits {
  const char* words;
  bool (*accept)(double);
};
constexpr bool accept_any(double) { return true; }
constexpr Limits kDeviation{"a number >= 0", [](double x) { return x >= 0; }};
constexpr Limits kPositive{"a number > 0", [](double x) { return x > 0; }};
constexpr Limits kProbability{"a probability in [0, 1), 0 for none",
                              [](double x) { return x >= 0 && x < 1; }};
constexpr Limits kDegrees{"a number of degrees", accept_any};
constexpr Limits kTurnRate{"a number of degrees per second", accept_any};
constexpr Limits kMetres{"a number of metres", accept_any};
constexpr Limits kDelay{"a number of seconds within [-10, 10]", [](double x) { return std::abs(x) <= 10; }};
constexpr Limits kAnchors{"a whole number from 0 to 1000",
                          [](double x) { return x >= 0 && x <= 1000 && x == std::floor(x); }};

/// One key: how to write a value and how to show it. `limits` says in words what is accepted.
struct Key {
  std::string name, limits;
  std::function<bool(S&, std::string_view)> set;  ///< false: not accepted
  std::function<std::string(const S&)> text;
  std::optional<VehicleKind> vehicle;  ///< the one that it means something for; none: every one
};

/// What a member of a group of the settings holds.
template <auto Group, auto Member>
using Held = std::remove_cvref_t<decltype((std::declval<S&>().*Group).*Member)>;

template <auto Group, auto Member>
Key number_key(std::string name, Limits limits, std::optional<VehicleKind> vehicle = {}) {
  return {std::move(name), limits.words,
          [accept = limits.accept](S& settings, std::string_view text) {
            const std::optional<double> number = parse_finite(text);
            if (!number || !accept(*number)) return false;
            (settings.*Group).*Member = static_cast<Held<Group, Member>>(*number);
            return true;
          },
          [](const S& settings) { return fmt::format("{}", (settings.*Group).*Member); }, vehicle};
}

/// A key that holds one of several words.
template <auto Group, auto Member>
Key word_key(std::string name, std::vector<std::pair<std::string, Held<Group, Member>>> words,
             std::optional<VehicleKind> vehicle = {}) {
  std::string limits = "one of";
  for (const auto& [word, value] : words) limits += fmt::format(" \"{}\"", word);
  return {std::move(name), std::move(limits),
          [=](S& settings, std::string_view text) {
            for (const auto& [word, value] : words) {
              if (word != text) continue;
              (settings.*Group).*Member = value;
              return true;
            }
            return false;
          },
          [=](const S& settings) {
            for (const auto& [word, value] : words)
              if (value == (settings.*Group).*Member) return word;
            return std::string();
          },
          vehicle};
}

std::vector<std::pair<std::string, std::string>> estimator_words() {
  std::vector<std::pair<std::string, std::string>> words;
  for (const EstimatorKind& kind : estimator_kinds()) words.emplace_back(kind.name, kind.name);
  return words;
}

std::vector<Key> all_keys() {
  using Filter = ReplayFilterSettings;
  using Initial = ReplayInitial;
  using Noise = ReplayNoise;
  using Sensor = ReplaySensor;
  using Truth = ReplayTruth;
  constexpr auto kWorld = &S::world;
  constexpr auto kFilter = &S::filter;
  constexpr auto kInitial = &S::initial;
  constexpr auto kNoise = &S::noise;
  constexpr auto kSensor = &S::sensor;
  constexpr auto kTruth = &S::truth;
  constexpr auto kCar = VehicleKind::car, kUnicycle = VehicleKind::unicycle;
  return {
      word_key<kWorld, &ReplayWorld::full>("world.observability", {{"partial", false}, {"full", true}}),
      number_key<kWorld, &ReplayWorld::anchors>("world.anchors", kAnchors),
      word_key<kFilter, &Filter::inflation>(
          "filter.inflation",
          {{"none", Inflation::none}, {"full", Inflation::full}, {"map", Inflation::map}}),
      word_key<kFilter, &Filter::solution>("filter.solution", {{"pairwise", InflationSolution::pairwise},
                                                               {"min-trace", InflationSolution::min_trace},
                                                               {"sequential", InflationSolution::sequential},
                                                               {"batch", InflationSolution::batch}}),
      word_key<kFilter, &Filter::association>(
          "filter.association",
          {{"survey", ReplayAssociation::survey}, {"compatibility", ReplayAssociation::compatibility}}),
      number_key<kFilter, &Filter::gate>("filter.gate", kProbability),
      word_key<kFilter, &Filter::jacobians>(
          "filter.jacobians", {{"estimate", ReplayJacobians::estimate}, {"truth", ReplayJacobians::truth}},
          kUnicycle),
      word_key<kFilter, &Filter::estimator>("filter.estimator", estimator_words()),
      number_key<kInitial, &Initial::position_std>("initial.position_std", kDeviation),
      number_key<kInitial, &Initial::heading_std_deg>("initial.heading_std_deg", kDeviation),
      number_key<kInitial, &Initial::heading_deg>("initial.heading_deg", kDegrees, kCar),
      number_key<kNoise, &Noise::speed_std>("noise.speed_std", kDeviation),
      number_key<kNoise, &Noise::steering_std_deg>("noise.steering_std_deg", kDeviation, kCar),
      number_key<kNoise, &Noise::turn_rate_std>("noise.turn_rate_std", kDeviation, kUnicycle),
      number_key<kNoise, &Noise::range_std>("noise.range_std", kPositive),
      number_key<kNoise, &Noise::bearing_std_deg>("noise.bearing_std_deg", kPositive),
      word_key<kSensor, &Sensor::range>(
          "sensor.range", {{"distance", RangeKind::distance}, {"depth", RangeKind::depth}}, kUnicycle),
      number_key<kSensor, &Sensor::range_offset_m>("sensor.range_offset_m", kMetres),
      number_key<kSensor, &Sensor::range_scale>("sensor.range_scale", kPositive),
      number_key<kSensor, &Sensor::bearing_offset_deg>("sensor.bearing_offset_deg", kDegrees),
      number_key<kSensor, &Sensor::odometry_delay_s>("sensor.odometry_delay_s", kDelay),
      number_key<kSensor, &Sensor::speed_scale>("sensor.speed_scale", kPositive),
      number_key<kSensor, &Sensor::turn_scale>("sensor.turn_scale", kPositive, kUnicycle),
      number_key<kSensor, &Sensor::turn_drift_deg_s>("sensor.turn_drift_deg_s", kTurnRate, kUnicycle),
      number_key<kTruth, &Truth::position_std>("truth.position_std", kDeviation),
      number_key<kTruth, &Truth::heading_std_deg>("truth.heading_std_deg", kDeviation, kUnicycle),
  };
}

/// Those that mean something for a vehicle.
std::vector<Key> keys_of(VehicleKind vehicle) {
  std::vector<Key> keys = all_keys();
  std::erase_if(keys, [&](const Key& key) { return key.vehicle && key.vehicle != vehicle; });
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
  for (const Key& known : keys_of(settings.vehicle)) {
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
  for (const Key& key : keys_of(settings.vehicle)) result.push_back({key.name, key.text(settings)});
  return result;
}

}  // namespace credence::internal
