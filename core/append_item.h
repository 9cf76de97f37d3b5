#pragma once

#include <algorithm>
#include <cstddef>
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

}  // namespace credence::internal
