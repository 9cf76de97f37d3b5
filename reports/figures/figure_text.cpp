#include "reports/figures/figure_text.h"

#include <array>
#include <cstdint>
#include <string_view>

#include "core/utf8.h"
#include "reports/figures/canvas.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

// Thousandths of the font's size for ' ' to '~', from the metrics of Helvetica (Arial and Liberation Sans
// have the same).
constexpr std::array<std::int16_t, 95> kHelvetica{
    278, 278, 355, 556, 556, 889, 667,  191, 333, 333, 389, 584, 278, 333, 278, 278,  // to '/'
    556, 556, 556, 556, 556, 556, 556,  556, 556, 556,                                // digits
    278, 278, 584, 584, 584, 556, 1015,                                               // to '@'
    667, 667, 722, 722, 667, 611, 778,  722, 278, 500, 667, 556, 833, 722, 778, 667,  // to 'P'
    778, 722, 667, 611, 722, 667, 944,  667, 667, 611, 278, 278, 278, 469, 556, 333,  // to '`'
    556, 556, 500, 556, 556, 278, 556,  556, 222, 222, 500, 222, 833, 556, 556, 556,  // to 'p'
    556, 333, 500, 278, 556, 500, 722,  500, 500, 500, 334, 260, 334, 584};
constexpr double kOtherLetter = 0.6;  // Greek, accents, signs
constexpr double kWideLetter = 1.0;
// DejaVu Sans and Verdana are wider by about this.
constexpr double kWidestFont = 1.15;

double letters_width(std::string_view words) {
  double width = 0.0;
  for (std::size_t i = 0; i < words.size();) {
    const std::size_t start = i;
    const char32_t c = next_code_point(words, i);
    if (c >= U' ' && c <= U'~') {
      width += 1e-3 * kHelvetica[c - U' '];
    } else {
      const std::size_t columns = display_width(words.substr(start, i - start));
      width += columns == 2 ? kWideLetter : columns == 1 ? kOtherLetter : 0.0;
    }
  }
  return width;
}

}  // namespace

std::vector<TextRun> text_runs(const FigureText& text) {
  const std::string line = printable_line(text.text);
  if (!text.has_markup) return {{line}};
  std::vector<TextRun> runs;
  std::string base;
  for (std::size_t i = 0; i < line.size();) {
    const bool opens = is_in(line[i], "_^") && i + 1 < line.size() && line[i + 1] == '{';
    const std::size_t close = opens ? line.find('}', i) : std::string::npos;
    if (close == std::string::npos) {
      base += line[i++];
      continue;
    }
    if (!base.empty()) runs.push_back({std::move(base)});
    base.clear();
    runs.push_back(
        {line.substr(i + 2, close - i - 2), line[i] == '_' ? TextLevel::subscript : TextLevel::superscript});
    i = close + 1;
  }
  if (!base.empty() || runs.empty()) runs.push_back({std::move(base)});
  return runs;
}

double text_width(const FigureText& text) {
  double width = 0.0;
  for (const TextRun& run : text_runs(text)) {
    width += letters_width(run.words) * (run.level == TextLevel::base ? kLabelFont : kScriptFont);
  }
  return kWidestFont * width;
}

}  // namespace credence::internal
