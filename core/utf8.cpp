#include "core/utf8.h"

#include <array>

namespace credence::internal {
namespace {

constexpr char32_t kReplacement = 0xFFFD, kLast = 0x10FFFF;

/// 10xxxxxx, which goes on with a code point.
bool is_continuation(unsigned char byte) { return (byte & 0xC0u) == 0x80u; }

bool is_surrogate(char32_t c) { return c >= 0xD800 && c <= 0xDFFF; }

}  // namespace

char32_t next_code_point(std::string_view text, std::size_t& position) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(position++);
  if (lead < 0x80) return lead;
  const unsigned length = lead >= 0xF0 && lead < 0xF8 ? 3 : lead >= 0xE0 ? 2 : 1;
  if (lead < 0xC2 || lead >= 0xF5 || position + length > text.size()) return kReplacement;
  char32_t code_point = lead & (0x3Fu >> length);
  for (unsigned i = 0; i < length; ++i) {
    const unsigned char next = byte(position + i);
    if (!is_continuation(next)) return kReplacement;
    code_point = (code_point << 6) | (next & 0x3Fu);
  }
  // Overlong forms and surrogates are not UTF-8.
  constexpr std::array<char32_t, 4> kSmallest{0, 0x80, 0x800, 0x10000};
  if (code_point < kSmallest[length] || is_surrogate(code_point) || code_point > kLast) return kReplacement;
  position += length;
  return code_point;
}

void append_utf8(std::string& out, char32_t c) {
  const auto put = [&out](char32_t bits) { out.push_back(static_cast<char>(bits)); };
  if (is_surrogate(c) || c > kLast) c = kReplacement;
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | (c >> 6));
    put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | (c >> 12));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | (c >> 18));
    put(0x80 | ((c >> 12) & 0x3F));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  }
}

std::string_view beginning_of_text(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return text;
  while (longest > 0 && is_continuation(static_cast<unsigned char>(text[longest]))) --longest;
  return text.substr(0, longest);
}

}  // namespace credence::internal
