#include "reports/figures/gnuplot_text.h"

#include <string_view>

#include "reports/render/utf8_text.h"

namespace credence {
namespace {

constexpr std::string_view kXmlSpecial = "<>\"'`";
constexpr std::string_view kEnhancedSpecial = "\\{}_^@&~";

void append_literal(std::string& out, std::string_view bytes, GnuplotFormat format) {
  for (const char c : bytes) {
    const bool enhanced = is_in(c, kEnhancedSpecial);
    if (format == GnuplotFormat::svg && (enhanced || is_in(c, kXmlSpecial))) {
      append_utf8(out, kEscapedCharacters + static_cast<unsigned char>(c));
    } else if (c == '\'') {
      // Doubling a quote is gnuplot's way, but gnuplot 5.4 misreads a doubled quote at the start of a string.
      out += "\\047";
    } else {
      if (enhanced) out += '\\';
      out += c;
    }
  }
}

// The closing brace of "_{...}" or "^{...}" at `start`, or npos.
std::size_t markup_end(std::string_view line, std::size_t start) {
  const bool opens = is_in(line[start], "_^") && start + 1 < line.size() && line[start + 1] == '{';
  return opens ? line.find('}', start) : std::string_view::npos;
}

}  // namespace

std::string gnuplot_string(const FigureText& text, GnuplotFormat format) {
  const std::string words = printable_line(text.text);
  const std::string_view line = words;
  std::string out = "'";
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t close = text.has_markup ? markup_end(line, i) : std::string_view::npos;
    if (close == std::string_view::npos) {
      append_literal(out, line.substr(i, 1), format);
      ++i;
    } else {
      out += line.substr(i, 2);
      append_literal(out, line.substr(i + 2, close - i - 2), format);
      out += '}';
      i = close + 1;
    }
  }
  return out + "'";
}

}  // namespace credence
