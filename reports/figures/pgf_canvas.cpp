#include "reports/figures/pgf_canvas.h"

#include <fmt/format.h>

#include <utility>

#include "reports/figures/figure_text.h"
#include "reports/render/latex_words.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr double kPgfPoints = kPaperFontPoints / kLabelFont;

std::string pgf_point(CanvasPoint p) {
  return fmt::format("\\pgfqpoint{{{:.3f}bp}}{{{:.3f}bp}}", kPgfPoints * p.x, kPgfPoints * p.y);
}

std::string pgf_colour(std::uint32_t rgb) {
  const auto channel = [rgb](unsigned shift) { return static_cast<double>((rgb >> shift) & 0xFFu) / 255.0; };
  return fmt::format("{:.4f},{:.4f},{:.4f}", channel(16), channel(8), channel(0));
}

}  // namespace

PgfCanvas::PgfCanvas(double width, double height, std::string_view description) : height_(height) {
  pgf_ = fmt::format(
      "% {}\n% In the preamble: \\usepackage{{pgf}}; in the text: \\input{{this file}}\n"
      "\\begin{{pgfpicture}}\n\\pgfpathrectangle{{\\pgfpointorigin}}{{{}}}\n\\pgfusepath{{use as bounding "
      "box}}\n"
      "\\pgfsetroundjoin\n",
      printable_line(description), pgf_point({width, height}));
}

void PgfCanvas::trace(std::span<const CanvasPath> paths, bool close) {
  for (const CanvasPath& path : paths) {
    for (std::size_t i = 0; i < path.size(); ++i) {
      pgf_ += fmt::format("\\pgfpath{}to{{{}}}%\n", i == 0 ? "move" : "line",
                          pgf_point({path[i].x, height_ - path[i].y}));
    }
    if (close || path.size() == 1) pgf_ += "\\pgfpathclose\n";
  }
}

void PgfCanvas::stroke(std::span<const CanvasPath> lines, const Pen& pen) {
  const Dashes dashes = dashes_of(pen.stroke, pen.width);
  const std::string pattern =
      pen.stroke == StrokeStyle::solid
          ? std::string()
          : fmt::format("{{{:.3f}bp}}{{{:.3f}bp}}", kPgfPoints * dashes.on, kPgfPoints * dashes.off);
  pgf_ += fmt::format(
      "\\begin{{pgfscope}}\n\\definecolor{{credence}}{{rgb}}{{{}}}\\pgfsetstrokecolor{{credence}}"
      "\\pgfsetlinewidth{{{:.3f}bp}}\\pgfset{}cap\\pgfsetdash{{{}}}{{0bp}}\n",
      pgf_colour(pen.rgb), kPgfPoints * pen.width, pen.dots ? "round" : "butt", pattern);
  trace(lines, false);
  pgf_ += "\\pgfusepath{stroke}\n\\end{pgfscope}\n";
}

void PgfCanvas::fill(std::span<const CanvasPath> outlines, const Brush& brush) {
  pgf_ += fmt::format(
      "\\begin{{pgfscope}}\n\\definecolor{{credence}}{{rgb}}{{{}}}\\pgfsetfillcolor{{credence}}"
      "\\pgfsetfillopacity{{{:.3f}}}\n",
      pgf_colour(brush.rgb), brush.opacity);
  trace(outlines, true);
  pgf_ += "\\pgfusepath{fill}\n\\end{pgfscope}\n";
}

void PgfCanvas::write(const FigureText& text, CanvasPoint at, const Lettering& lettering) {
  std::string words;
  for (const TextRun& run : text_runs(text)) {
    const char* const command = run.level == TextLevel::superscript ? "\\textsuperscript"
                                : run.level == TextLevel::subscript ? "\\textsubscript"
                                                                    : "";
    words +=
        *command == '\0' ? latex_words(run.words) : fmt::format("{}{{{}}}", command, latex_words(run.words));
  }
  const char* const anchor = lettering.anchor == TextAnchor::start ? "left,"
                             : lettering.anchor == TextAnchor::end ? "right,"
                                                                   : "";
  pgf_ += fmt::format(
      "\\definecolor{{credence}}{{rgb}}{{{}}}%\n\\pgftext[{}base,x={:.3f}bp,y={:.3f}bp{}]{{\\color{{credence}"
      "}\\fontsize{{{}}}{{{}}}\\selectfont{} {}}}\n",
      pgf_colour(lettering.rgb), anchor, kPgfPoints * at.x, kPgfPoints * (height_ - at.y),
      lettering.upright ? ",rotate=90" : "", kPaperFontPoints, 1.2 * kPaperFontPoints,
      lettering.bold ? "\\bfseries" : "", words);
}

std::string PgfCanvas::finish() && { return std::move(pgf_) + "\\end{pgfpicture}%\n"; }

}  // namespace credence::internal
