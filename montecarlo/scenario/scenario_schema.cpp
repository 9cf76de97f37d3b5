#include "montecarlo/scenario/scenario_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace credence {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr Interval kPositive{0.0, kInfinity, true, true};
constexpr Interval kNotNegative{0.0, kInfinity, false, true};

template <auto Part, auto Member>
RealField real(Interval interval) {
  return {[](const Scenario& s) { return (s.*Part).*Member; },
          [](Scenario& s, double value) { (s.*Part).*Member = value; }, interval};
}

template <auto Part, auto Member>
IntegerField integer(std::int64_t low, std::int64_t high) {
  return {[](const Scenario& s) { return static_cast<std::int64_t>((s.*Part).*Member); },
          [](Scenario& s, std::int64_t value) {
            auto& member = (s.*Part).*Member;
            member = static_cast<std::remove_reference_t<decltype(member)>>(value);
          },
          low, high};
}

template <auto Part, auto Member, class Enum>
ChoiceField choice(Enum last) {
  ChoiceField field{[](const Scenario& s) { return static_cast<std::size_t>((s.*Part).*Member); },
                    [](Scenario& s, std::size_t index) { (s.*Part).*Member = static_cast<Enum>(index); },
                    {}};
  for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i) {
    field.words.push_back(to_string(static_cast<Enum>(i)));
  }
  return field;
}

bool always(const Scenario&) { return true; }
bool is_monobot(const Scenario& s) { return s.world.model == WorldModel::monobot; }
bool is_planar(const Scenario& s) { return s.world.model == WorldModel::planar; }
bool is_unicycle(const Scenario& s) { return is_planar(s) && s.world.vehicle == VehicleKind::unicycle; }
bool is_steered(const Scenario& s) { return is_planar(s) && s.world.vehicle != VehicleKind::unicycle; }
bool is_anchored(const Scenario& s) { return s.world.observability == Observability::full; }
bool is_of_rank(const Scenario& s) { return s.filter.inflation == FilterInflation::rank; }
bool is_decorrelating(const Scenario& s) {
  return s.filter.inflation == FilterInflation::full || s.filter.inflation == FilterInflation::map;
}
bool misses(const Scenario& s) { return s.noise.detection_probability < 1.0; }
bool stops_by_verdict(const Scenario& s) { return s.stop.verdict != StopVerdict::none; }
bool may_stop_as_consistent(const Scenario& s) { return s.stop.verdict == StopVerdict::either; }

constexpr std::string_view kOnlyMonobot = "with world.model = \"monobot\"";
constexpr std::string_view kOnlyPlanar = "with world.model = \"planar\"";
constexpr std::string_view kOnlyUnicycle =
    "with world.model = \"planar\" and world.vehicle = \"unicycle\" (bicycle and car have steering_std_deg)";
constexpr std::string_view kOnlySteered =
    "with world.model = \"planar\" and world.vehicle = \"bicycle\" or \"car\" (the unicycle has "
    "turn_rate_std)";
constexpr std::string_view kOnlyRank = "with filter.inflation = \"rank\"";

std::vector<ScenarioKey> world_keys() {
  using W = WorldSettings;
  constexpr auto kWorld = &Scenario::world;
  return {
      {"world", "model", "", "vehicle on a line (linear), or in the plane with range and bearing",
       choice<kWorld, &W::model>(WorldModel::planar), always, "", always},
      {"world", "landmarks", "", "landmarks that are states; 0 only with anchors",
       integer<kWorld, &W::landmarks>(0, 1'000'000), always, "", always},
      {"world", "observability", "",
       "partial: all landmarks are states; full: `anchors` more stand at known positions",
       choice<kWorld, &W::observability>(Observability::full), always, "", always},
      {"world", "anchors", "",
       "known landmarks that are no states; of no effect with observability = \"partial\"; the plane needs 2 "
       "to be fully observable",
       integer<kWorld, &W::anchors>(0, 1'000'000), always, "", is_anchored},
      {"world", "vehicle", "", "motion model; car is the bicycle with the sensor off the axle",
       choice<kWorld, &W::vehicle>(VehicleKind::car), is_planar, kOnlyPlanar, is_planar},
      {"world", "path", "", "path that the vehicle drives again and again",
       choice<kWorld, &W::path>(PathShape::line), is_planar, kOnlyPlanar, is_planar},
      {"world", "path_radius", "m", "radius of the circle and of both loops of the eight; half the line",
       real<kWorld, &W::path_radius>(kPositive), is_planar, kOnlyPlanar, is_planar},
      {"world", "speed", "m/s", "speed along the path", real<kWorld, &W::speed>(kPositive), is_planar,
       kOnlyPlanar, is_planar},
      {"world", "dt", "s", "time of one step", real<kWorld, &W::dt>(kPositive), is_planar, kOnlyPlanar,
       is_planar},
      {"world", "sensor_min_range", "m", "landmarks nearer than this are not seen",
       real<kWorld, &W::sensor_min_range>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
      {"world", "sensor_range", "m", "landmarks farther away are not seen",
       real<kWorld, &W::sensor_range>(kPositive), is_planar, kOnlyPlanar, is_planar},
      {"world", "field_of_view_deg", "deg", "full angle of sight, centred on the heading",
       real<kWorld, &W::field_of_view_deg>({0.0, 360.0, true, false}), is_planar, kOnlyPlanar, is_planar},
  };
}

std::vector<ScenarioKey> noise_keys() {
  using N = NoiseSettings;
  using I = InitialSettings;
  constexpr auto kNoise = &Scenario::noise;
  constexpr auto kInitial = &Scenario::initial;
  return {
      {"noise", "process_variance", "m^2", "Q, variance of the vehicle's motion in one step",
       real<kNoise, &N::process_variance>(kNotNegative), is_monobot, kOnlyMonobot, is_monobot},
      {"noise", "measurement_variance", "m^2", "R, variance of each measurement",
       real<kNoise, &N::measurement_variance>(kNotNegative), is_monobot, kOnlyMonobot, is_monobot},
      {"noise", "initial_variance", "m^2", "variance of every state at the start",
       real<kNoise, &N::initial_variance>(kNotNegative), is_monobot, kOnlyMonobot, is_monobot},
      {"noise", "speed_std", "m/s", "standard deviation of the speed",
       real<kNoise, &N::speed_std>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
      {"noise", "turn_rate_std", "rad/s", "standard deviation of the turn rate",
       real<kNoise, &N::turn_rate_std>(kNotNegative), is_unicycle, kOnlyUnicycle, is_unicycle},
      {"noise", "steering_std_deg", "deg", "standard deviation of the steering angle",
       real<kNoise, &N::steering_std_deg>(kNotNegative), is_steered, kOnlySteered, is_steered},
      {"noise", "range_std", "m", "standard deviation of a measured range",
       real<kNoise, &N::range_std>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
      {"noise", "bearing_std_deg", "deg", "standard deviation of a measured bearing",
       real<kNoise, &N::bearing_std_deg>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
      {"noise", "detection_probability", "",
       "chance that a landmark in view is measured at a step; the others are missed",
       real<kNoise, &N::detection_probability>({0.0, 1.0, true, false}), always, "", misses},
      {"initial", "position_std", "m", "standard deviation of each coordinate of the vehicle at the start",
       real<kInitial, &I::position_std>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
      {"initial", "heading_std_deg", "deg", "standard deviation of the heading at the start",
       real<kInitial, &I::heading_std_deg>(kNotNegative), is_planar, kOnlyPlanar, is_planar},
  };
}

std::vector<ScenarioKey> filter_keys() {
  using F = FilterSettings;
  constexpr auto kFilter = &Scenario::filter;
  return {
      {"filter", "inflation", "",
       "what is decorrelated: nothing, vehicle and map, the map only; rank: a constant covariance is added",
       choice<kFilter, &F::inflation>(FilterInflation::rank), always, "", always},
      {"filter", "solution", "",
       "bound that decorrelates: sum over pairs, exact least trace, exact after each scalar measurement (map "
       "only, O(N)), or the same without any gain for the map; of no effect with inflation = \"none\" or "
       "\"rank\"",
       choice<kFilter, &F::solution>(InflationSolution::drop), always, "", is_decorrelating},
      {"filter", "process_scale", "", "process variance the filter assumes, over the true one",
       real<kFilter, &F::process_scale>(kPositive), always, "", always},
      {"filter", "measurement_scale", "", "measurement variance the filter assumes, over the true one",
       real<kFilter, &F::measurement_scale>(kPositive), always, "", always},
      {"filter", "inflation_rank", "", "rank of the constant added covariance",
       integer<kFilter, &F::inflation_rank>(0, 3'000'000), is_of_rank, kOnlyRank, is_of_rank},
      {"filter", "inflation_range", "",
       "where the range of the constant added covariance lies: anywhere, in the landmarks, containing the "
       "vehicle's own noise, in the differences of landmarks",
       choice<kFilter, &F::inflation_range>(InflationRange::difference), is_of_rank, kOnlyRank, is_of_rank},
      {"filter", "inflation_scale", "m^2", "every non-zero eigenvalue of the constant added covariance",
       real<kFilter, &F::inflation_scale>(kPositive), is_of_rank, kOnlyRank, is_of_rank},
  };
}

std::vector<ScenarioKey> study_keys() {
  using S = StudySettings;
  constexpr auto kStudy = &Scenario::study;
  return {
      {"study", "runs", "", "independent runs", integer<kStudy, &S::runs>(1, 1'000'000'000), always, "",
       always},
      {"study", "steps", "", "steps of one run", integer<kStudy, &S::steps>(1, 10'000'000), always, "",
       always},
      {"study", "seed", "", "first key of all random numbers",
       integer<kStudy, &S::seed>(0, std::numeric_limits<std::int64_t>::max()), always, "", always},
      {"study", "confidence", "", "of every interval and verdict",
       real<kStudy, &S::confidence>({0.0, 1.0, true, true}), always, "", always},
  };
}

std::vector<ScenarioKey> stop_keys() {
  using S = StopSettings;
  constexpr auto kStop = &Scenario::stop;
  return {
      {"study.stop", "verdict", "",
       "end the study when the filter is proved inconsistent, or either that or consistent within a factor; "
       "valid however often one looks",
       choice<kStop, &S::verdict>(StopVerdict::either), always, "", stops_by_verdict},
      {"study.stop", "consistent_within", "", "P is then proved right within the factor 1 + this",
       real<kStop, &S::consistent_within>(kPositive), always, "", may_stop_as_consistent},
      {"study.stop", "precision", "",
       "end the study when the mean NEES is known to this relative half-width; 0: do not",
       real<kStop, &S::precision>(kNotNegative), always, "",
       [](const Scenario& s) { return s.stop.precision > 0.0; }},
      {"study.stop", "max_runs", "", "most runs, in the place of study.runs; 0: study.runs",
       integer<kStop, &S::max_runs>(0, 1'000'000'000), always, "",
       [](const Scenario& s) { return s.stop.max_runs > 0; }},
      {"study.stop", "max_seconds", "s",
       "no chunk of runs is begun later; the only limit that depends on the machine; 0: none",
       real<kStop, &S::max_seconds>(kNotNegative), always, "",
       [](const Scenario& s) { return s.stop.max_seconds > 0.0; }},
  };
}

std::vector<ScenarioKey> all_keys() {
  std::vector<ScenarioKey> keys = world_keys();
  for (auto&& more : {noise_keys(), filter_keys(), study_keys(), stop_keys()}) {
    keys.insert(keys.end(), more.begin(), more.end());
  }
  return keys;
}

std::string interval_text(const Interval& interval) {
  const std::string low = fmt::format("{} {}", interval.low_open ? ">" : ">=", interval.low);
  if (interval.high == kInfinity) return "a finite number " + low;
  return fmt::format("a number {} and {} {}", low, interval.high_open ? "<" : "<=", interval.high);
}

bool contains(const Interval& interval, double value) {
  return std::isfinite(value) && (interval.low_open ? value > interval.low : value >= interval.low) &&
         (interval.high_open ? value < interval.high : value <= interval.high);
}

std::string words_text(const ChoiceField& field) {
  std::string text = "one of";
  for (const std::string_view word : field.words) {
    text += fmt::format("{} \"{}\"", text.back() == 'f' ? "" : ",", word);
  }
  return text;
}

struct AcceptedText {
  std::string operator()(const RealField& field) const { return interval_text(field.accepted); }
  std::string operator()(const IntegerField& field) const {
    return fmt::format("an integer from {} to {}", field.low, field.high);
  }
  std::string operator()(const ChoiceField& field) const { return words_text(field); }
};

/// Sets one field; what it returns is as for set_key.
struct Setter {
  const SettingValue& value;
  Scenario& scenario;

  template <class T>
  const T* scalar() const {
    const auto* any = std::get_if<ScalarValue>(&value);
    return any == nullptr ? nullptr : std::get_if<T>(any);
  }

  std::string refuse(const std::string& accepted) const { return fmt::format("must be {}", accepted); }
  std::string refuse_type(const std::string& accepted) const {
    const std::string_view type = type_text(value);
    return fmt::format("must be {}, not {}{}{}", accepted, type, type.empty() ? "" : " ", value_text(value));
  }

  std::string operator()(const RealField& field) const {
    double number = 0.0;
    if (const auto* real = scalar<double>()) {
      number = *real;
    } else if (const auto* whole = scalar<std::int64_t>()) {
      number = static_cast<double>(*whole);
    } else {
      return refuse_type(interval_text(field.accepted));
    }
    if (!contains(field.accepted, number)) return refuse(interval_text(field.accepted));
    field.set(scenario, number + 0.0);  // -0 would be another text for the same value
    return {};
  }

  std::string operator()(const IntegerField& field) const {
    const auto* whole = scalar<std::int64_t>();
    if (whole == nullptr) return refuse_type(AcceptedText{}(field));
    if (*whole < field.low || *whole > field.high) return refuse(AcceptedText{}(field));
    field.set(scenario, *whole);
    return {};
  }

  std::string operator()(const ChoiceField& field) const {
    const auto* word = scalar<std::string>();
    if (word == nullptr) return refuse_type(words_text(field));
    const auto found = std::find(field.words.begin(), field.words.end(), *word);
    if (found == field.words.end()) {
      const std::string_view close = closest_word(*word, field.words);
      return refuse(words_text(field)) + (close.empty() ? "" : fmt::format("; did you mean \"{}\"?", close));
    }
    field.set(scenario, static_cast<std::size_t>(found - field.words.begin()));
    return {};
  }
};

}  // namespace

std::string ScenarioKey::path() const { return fmt::format("{}.{}", section, name); }

std::span<const ScenarioKey> scenario_keys() {
  static const std::vector<ScenarioKey> keys = all_keys();
  return keys;
}

std::vector<std::string_view> scenario_sections() {
  std::vector<std::string_view> sections;
  for (const ScenarioKey& key : scenario_keys()) {
    if (sections.empty() || sections.back() != key.section) sections.push_back(key.section);
  }
  return sections;
}

const ScenarioKey* find_scenario_key(std::string_view section, std::string_view name) {
  const auto keys = scenario_keys();
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const ScenarioKey& key) {
    return key.section == section && key.name == name;
  });
  return found == keys.end() ? nullptr : &*found;
}

std::string accepted_values(const ScenarioKey& key) { return std::visit(AcceptedText{}, key.field); }

ScalarValue key_value(const ScenarioKey& key, const Scenario& scenario) {
  if (const auto* real_field = std::get_if<RealField>(&key.field)) return real_field->get(scenario);
  if (const auto* integer_field = std::get_if<IntegerField>(&key.field)) return integer_field->get(scenario);
  const auto& choice_field = std::get<ChoiceField>(key.field);
  return std::string(choice_field.words[choice_field.get(scenario)]);
}

std::string set_key(const ScenarioKey& key, const SettingValue& value, Scenario& scenario) {
  return std::visit(Setter{value, scenario}, key.field);
}

Scenario starting_scenario(WorldModel model) {
  Scenario scenario = default_scenario(model);
  scenario.world.anchors = 1;
  return scenario;
}

}  // namespace credence
