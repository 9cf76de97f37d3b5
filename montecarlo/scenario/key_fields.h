#pragma once

#include <type_traits>

#include "montecarlo/scenario/scenario_schema.h"

/// @file
/// How a row of the table reaches its value: a member of the structs of scenario.h, or a value that a world
/// keeps under its path in Scenario::own.

namespace credence::internal {

template <auto Part, auto Member>
RealField real_field(Interval interval) {
  return {[](const Scenario& s) { return (s.*Part).*Member; },
          [](Scenario& s, double value) { (s.*Part).*Member = value; }, interval};
}

template <auto Part, auto Member>
IntegerField integer_field(std::int64_t low, std::int64_t high) {
  return {[](const Scenario& s) { return static_cast<std::int64_t>((s.*Part).*Member); },
          [](Scenario& s, std::int64_t value) {
            auto& member = (s.*Part).*Member;
            member = static_cast<std::remove_reference_t<decltype(member)>>(value);
          },
          low, high};
}

/// `last` is the last value of an enum from 0 on whose words to_string gives.
template <auto Part, auto Member, class Enum>
ChoiceField choice_field(Enum last) {
  ChoiceField field{[](const Scenario& s) { return static_cast<std::size_t>((s.*Part).*Member); },
                    [](Scenario& s, std::size_t index) { (s.*Part).*Member = static_cast<Enum>(index); },
                    {}};
  for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i) {
    field.words.push_back(to_string(static_cast<Enum>(i)));
  }
  return field;
}

/// Fields of Scenario::own. A value that equals the default is not kept, so that equal scenarios compare so.
RealField own_real(const std::string& path, double default_value, Interval interval);
IntegerField own_integer(const std::string& path, std::int64_t default_value, std::int64_t low,
                         std::int64_t high);
/// The first word is the default.
ChoiceField own_choice(const std::string& path, std::vector<std::string_view> words);

/// The row of a key whose value, not negative, a world keeps.
KeyRow own_row(std::string_view section, std::string_view name, std::string_view unit,
               std::string_view meaning, double default_value);

/// The value of a key by its path, such as "noise.range_std". Throws std::invalid_argument for a path that no
/// key of that type has.
double real_value(const Scenario& scenario, std::string_view path);
std::int64_t integer_value(const Scenario& scenario, std::string_view path);
std::string_view word_value(const Scenario& scenario, std::string_view path);

/// The value of a RowsField or NamesField; empty where it is not given.
NumberRows rows_value(const Scenario& scenario, std::string_view path);
std::vector<std::string> names_value(const Scenario& scenario, std::string_view path);

}  // namespace credence::internal
