#include "reports/render/utf8_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/utf8.h"

namespace credence::internal {
namespace {

struct CodeRange {
  char32_t first, last;
};

template <std::size_t N>
bool contains(const std::array<CodeRange, N>& ranges, char32_t c) {
  return std::ranges::any_of(ranges, [c](CodeRange r) { return r.first <= c && c <= r.last; });
}

// Zero-width and combining characters.
constexpr std::array<CodeRange, 5> kNarrow{
    {{0x0300, 0x036F}, {0x1AB0, 0x1AFF}, {0x20D0, 0x20FF}, {0xFE00, 0xFE0F}, {0xFE20, 0xFE2F}}};
constexpr std::array<CodeRange, 8> kWide{{{0x1100, 0x115F},
                                          {0x2E80, 0xA4CF},
                                          {0xAC00, 0xD7A3},
                                          {0xF900, 0xFAFF},
                                          {0xFE30, 0xFE6F},
                                          {0xFF00, 0xFF60},
                                          {0x1F300, 0x1FAFF},
                                          {0x20000, 0x3FFFD}}};
// Direction marks and zero-width characters can make a name read as another one; private use has no meaning.
constexpr std::array<CodeRange, 8> kHidden{{{0x200B, 0x200F},
                                            {0x202A, 0x202E},
                                            {0x2060, 0x206F},
                                            {0xFEFF, 0xFEFF},
                                            {0xE000, 0xF8FF},
                                            {0xFFF0, 0xFFFB},
                                            {0xFFFE, 0xFFFF},
                                            {0xF0000, 0x10FFFF}}};
constexpr std::array<CodeRange, 3> kControl{{{0x00, 0x1F}, {0x7F, 0x9F}, {0x2028, 0x2029}}};

}  // namespace

std::string printable_line(std::string_view text) {
  std::string line;
  line.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const char32_t c = next_code_point(text, i);
    if (contains(kHidden, c)) continue;
    append_utf8(line, contains(kControl, c) ? U' ' : c);
  }
  return line;
}

std::string printable_json(std::string json) {
  const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x7F; };
  if (std::ranges::all_of(json, is_ascii)) return json;
  std::string text;
  text.reserve(json.size());
  for (std::size_t i = 0; i < json.size();) {
    const std::size_t plain = i;
    while (i < json.size() && is_ascii(json[i])) ++i;
    text.append(json, plain, i - plain);
    if (i == json.size()) break;
    const std::size_t begin = i;
    const char32_t c = next_code_point(json, i);
    // Of ASCII only DEL is left by whoever wrote it; private characters beyond 16 bits mean nothing to
    // anyone.
    const bool shown = c > 0xFFFF || (!contains(kHidden, c) && !contains(kControl, c));
    text += shown ? json.substr(begin, i - begin) : fmt::format("\\u{:04x}", static_cast<unsigned>(c));
  }
  return text;
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char32_t c = next_code_point(text, i);
    width += contains(kNarrow, c) ? 0 : contains(kWide, c) ? 2 : 1;
  }
  return width;
}

std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  if (display_width(text) <= width) return {std::string(text)};
  std::string line;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (!line.empty() && display_width(line) + 1 + display_width(word) > width) {
      lines.push_back(std::exchange(line, {}));
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  if (!line.empty() || lines.empty()) lines.push_back(line);
  return lines;
}

}  // namespace credence::internal
