#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace credence::internal {

/// Appends an item to a list in words: "a", then "a, b".
inline void append_item(std::string& list, std::string_view item, std::string_view separator = ", ") {
  if (!list.empty()) list += separator;
  list += item;
}

/// "a, b and 3 more": of a list in words no more than these.
inline std::string first_items(std::span<const std::string> items, std::size_t most) {
  std::string list;
  for (const std::string& item : items.first(std::min(most, items.size()))) append_item(list, item);
  return items.size() > most ? list + " and " + std::to_string(items.size() - most) + " more" : list;
}

/// "1 run", "2 runs".
template <std::integral Count>
std::string counted(Count n, std::string_view what) {
  return std::to_string(n).append(" ").append(what).append(n == 1 ? "" : "s");
}

/// "1st", "22nd", "512th", n ≥ 0.
inline std::string ordinal(std::int64_t n) {
  const std::int64_t last = n / 10 % 10 == 1 ? 0 : n % 10;
  return std::to_string(n) + (last == 1 ? "st" : last == 2 ? "nd" : last == 3 ? "rd" : "th");
}

}  // namespace credence::internal
