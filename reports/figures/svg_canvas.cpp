#include "reports/figures/svg_canvas.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include "reports/figures/figure_text.h"
#include "reports/render/html_text.h"

namespace credence::internal {
namespace {

std::int64_t hundredths(double value) { return std::llround(100.0 * value); }

// "12.5", "-.25": the shortest form of a number of hundredths.
std::string decimal(std::int64_t value) {
  const std::int64_t size = value < 0 ? -value : value;
  std::string text = value < 0 ? "-" : "";
  if (size >= 100 || size == 0) text += fmt::format("{}", size / 100);
  if (size % 100 != 0)
    text += size % 10 == 0 ? fmt::format(".{}", size % 100 / 10) : fmt::format(".{:02}", size % 100);
  return text;
}

std::string decimal(double value) { return decimal(hundredths(value)); }

// The data of a path, in steps from point to point, which are shorter than places.
class PathData {
 public:
  void add(const CanvasPath& path, bool close) {
    if (path.empty()) return;
    x_ = hundredths(path[0].x);
    y_ = hundredths(path[0].y);
    command('M');
    number(x_);
    number(y_);
    for (std::size_t i = 1; i < path.size(); ++i) step_to(hundredths(path[i].x), hundredths(path[i].y));
    if (close) command('z');
    if (!close && last_ == 'M') data_ += "h0";  // a dot
    last_ = '\0';
  }
  std::string take() { return std::move(data_); }

 private:
  void step_to(std::int64_t x, std::int64_t y) {
    const std::int64_t dx = x - x_;
    const std::int64_t dy = y - y_;
    if (dx == 0 && dy == 0) return;
    command(dy == 0 ? 'h' : dx == 0 ? 'v' : 'l');
    if (dx != 0) number(dx);
    if (dy != 0) number(dy);
    x_ = x;
    y_ = y;
  }
  // A letter stands for all numbers up to the next one.
  void command(char letter) {
    if (letter != last_) data_ += letter;
    last_ = letter;
  }
  void number(std::int64_t value) {
    const std::string text = decimal(value);
    const bool follows = data_.back() >= '0' && data_.back() <= '9';
    if (follows && text.front() != '-') data_ += ' ';
    data_ += text;
  }

  std::string data_;
  std::int64_t x_ = 0, y_ = 0;
  char last_ = '\0';
};

std::string data_of(std::span<const CanvasPath> paths, bool close) {
  PathData data;
  for (const CanvasPath& path : paths) data.add(path, close);
  return data.take();
}

std::string dashes_of(const Pen& pen) {
  if (pen.stroke == StrokeStyle::solid) return "";
  const Dashes dashes = dashes_of(pen.stroke, pen.width);
  return fmt::format(" stroke-dasharray=\"{} {}\"", decimal(dashes.on), decimal(dashes.off));
}

const char* anchor_of(TextAnchor anchor) {
  switch (anchor) {
    case TextAnchor::middle: return " text-anchor=\"middle\"";
    case TextAnchor::end: return " text-anchor=\"end\"";
    case TextAnchor::start: break;
  }
  return "";
}

}  // namespace

SvgCanvas::SvgCanvas(double width, double height, std::string_view description)
    : SvgCanvas(CanvasBox{0.0, width, 0.0, height}, description) {}

SvgCanvas::SvgCanvas(const CanvasBox& part, std::string_view description) {
  svg_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{0} {1} {2} {3}\" width=\"{2}\" height=\"{3}\" "
      "role=\"img\" aria-label=\"{4}\" font-family=\"'Helvetica Neue',Helvetica,Arial,sans-serif\" "
      "font-size=\"{5}\" fill=\"#{6:06x}\" stroke-linejoin=\"round\">\n",
      decimal(part.left), decimal(part.top), decimal(part.width()), decimal(part.height()),
      escape_html(description), decimal(kLabelFont), kInkColour);
}

void SvgCanvas::begin_group(std::string_view name) {
  svg_ += fmt::format("<g class=\"{}\">\n", escape_html(name));
}

void SvgCanvas::end_group() { svg_ += "</g>\n"; }

void SvgCanvas::stroke(std::span<const CanvasPath> lines, const Pen& pen) {
  svg_ += fmt::format("<path fill=\"none\" stroke=\"#{:06x}\" stroke-width=\"{}\"{}{} d=\"{}\"/>\n", pen.rgb,
                      decimal(pen.width), pen.dots ? " stroke-linecap=\"round\"" : "", dashes_of(pen),
                      data_of(lines, false));
}

void SvgCanvas::fill(std::span<const CanvasPath> outlines, const Brush& brush) {
  const std::string opacity =
      brush.opacity < 1.0 ? fmt::format(" fill-opacity=\"{}\"", decimal(brush.opacity)) : "";
  svg_ += fmt::format("<path fill=\"#{:06x}\"{} d=\"{}\"/>\n", brush.rgb, opacity, data_of(outlines, true));
}

void SvgCanvas::write(const FigureText& text, CanvasPoint at, const Lettering& lettering) {
  const std::string x = decimal(at.x);
  const std::string y = decimal(at.y);
  const std::string place = lettering.upright ? fmt::format("transform=\"translate({} {})rotate(-90)\"", x, y)
                                              : fmt::format("x=\"{}\" y=\"{}\"", x, y);
  const std::string colour =
      lettering.rgb == kInkColour ? "" : fmt::format(" fill=\"#{:06x}\"", lettering.rgb);
  svg_ += fmt::format("<text {}{}{}{}>", place, anchor_of(lettering.anchor),
                      lettering.bold ? " font-weight=\"bold\"" : "", colour);
  double lift = 0.0;  // of the present run over the base line
  for (const TextRun& run : text_runs(text)) {
    const double wanted = run.level == TextLevel::superscript ? kSuperscript
                          : run.level == TextLevel::subscript ? -kSubscript
                                                              : 0.0;
    const std::string words = escape_html(run.words);
    if (wanted == 0.0 && lift == 0.0) {
      svg_ += words;
    } else {
      svg_ += fmt::format("<tspan dy=\"{}\"{}>{}</tspan>", decimal(lift - wanted),
                          wanted == 0.0 ? "" : fmt::format(" font-size=\"{}\"", decimal(kScriptFont)), words);
    }
    lift = wanted;
  }
  svg_ += "</text>\n";
}

std::string SvgCanvas::finish() && { return std::move(svg_) + "</svg>\n"; }

}  // namespace credence::internal
