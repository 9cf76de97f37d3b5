#pragma once

#include <cstddef>
#include <string_view>

namespace credence::internal {

/// `text` without blanks at its ends.
inline std::string_view trim_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace credence::internal
