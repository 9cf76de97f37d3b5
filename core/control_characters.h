#pragma once

#include <cstddef>
#include <string_view>

namespace credence::internal {

/// Whether a name of someone else's holds what a terminal obeys instead of showing it: C0, DEL, C1 (U+0080 to
/// U+009F), or a separator of lines or paragraphs. `text` should be UTF-8 but need not.
inline bool has_control_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const unsigned first = byte(i), second = byte(i + 1), third = byte(i + 2);
    if (first < 0x20 || first == 0x7F) return true;
    if (first == 0xC2 && second >= 0x80 && second < 0xA0) return true;
    if (first == 0xE2 && second == 0x80 && (third == 0xA8 || third == 0xA9)) return true;
  }
  return false;
}

}  // namespace credence::internal
