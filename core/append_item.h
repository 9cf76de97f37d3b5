#pragma once

#include <string>
#include <string_view>

namespace credence::internal {

/// Appends an item to a list in words: "a", then "a, b".
inline void append_item(std::string& list, std::string_view item, std::string_view separator = ", ") {
  if (!list.empty()) list += separator;
  list += item;
}

}  // namespace credence::internal
