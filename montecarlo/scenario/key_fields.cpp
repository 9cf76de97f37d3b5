#include "montecarlo/scenario/key_fields.h"

#include <fmt/format.h>

#include <stdexcept>

namespace credence::internal {
namespace {

template <class T>
T own_value(const Scenario& scenario, std::string_view path, const T& default_value) {
  const auto found = scenario.own.find(path);
  return found == scenario.own.end() ? default_value : std::get<T>(found->second);
}

template <class T>
void set_own(Scenario& scenario, const std::string& path, const T& value, const T& default_value) {
  if (value == default_value) {
    scenario.own.erase(path);
  } else {
    scenario.own[path] = value;
  }
}

template <class Field>
const Field& field_at(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  const ScenarioKey* const key =
      dot == std::string_view::npos ? nullptr : find_scenario_key(path.substr(0, dot), path.substr(dot + 1));
  const Field* const field = key == nullptr ? nullptr : std::get_if<Field>(&key->field);
  if (field == nullptr) throw std::invalid_argument(fmt::format("{} is no key of that type", path));
  return *field;
}

}  // namespace

RealField own_real(const std::string& path, double default_value, Interval interval) {
  return {[=](const Scenario& s) { return own_value(s, path, default_value); },
          [=](Scenario& s, double value) { set_own(s, path, value, default_value); }, interval};
}

IntegerField own_integer(const std::string& path, std::int64_t default_value, std::int64_t low,
                         std::int64_t high) {
  return {[=](const Scenario& s) { return own_value(s, path, default_value); },
          [=](Scenario& s, std::int64_t value) { set_own(s, path, value, default_value); }, low, high};
}

ChoiceField own_choice(const std::string& path, std::vector<std::string_view> words) {
  return {[=](const Scenario& s) { return own_value(s, path, std::size_t{0}); },
          [=](Scenario& s, std::size_t index) { set_own(s, path, index, std::size_t{0}); }, std::move(words)};
}

KeyRow own_row(std::string_view section, std::string_view name, std::string_view unit,
               std::string_view meaning, double default_value) {
  return {section, name, unit, meaning,
          own_real(fmt::format("{}.{}", section, name), default_value, Interval::kNotNegative)};
}

double real_value(const Scenario& scenario, std::string_view path) {
  return field_at<RealField>(path).get(scenario);
}

std::int64_t integer_value(const Scenario& scenario, std::string_view path) {
  return field_at<IntegerField>(path).get(scenario);
}

std::string_view word_value(const Scenario& scenario, std::string_view path) {
  const auto& field = field_at<ChoiceField>(path);
  return field.words[field.get(scenario)];
}

NumberRows rows_value(const Scenario& scenario, std::string_view path) {
  return own_value(scenario, path, NumberRows{});
}

std::vector<std::string> names_value(const Scenario& scenario, std::string_view path) {
  return own_value(scenario, path, std::vector<std::string>{});
}

}  // namespace credence::internal
