#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string_view>

/// @file
/// The words of enumerations whose values are 0, 1, 2, …

namespace credence::internal {

/// The word of `value`, of words in the order of the values; empty for a value beyond them.
template <class Enum>
constexpr std::string_view word_of(Enum value, std::initializer_list<std::string_view> words) {
  const auto i = static_cast<std::size_t>(value);
  return i < words.size() ? words.begin()[i] : std::string_view();
}

/// The value, up to `last`, that to_string calls so.
template <class Enum>
std::optional<Enum> value_named(std::string_view word, Enum last) {
  for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i) {
    if (to_string(static_cast<Enum>(i)) == word) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

}  // namespace credence::internal
