#include "reports/figures/pgf_canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/utf8.h"
#include "reports/figures/figure_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr double kPgfPoints = kPaperFontPoints / kLabelFont;

// Characters that LaTeX reads as commands, and those that its usual fonts for text lack.
constexpr std::array<std::pair<char32_t, const char*>, 56> kLatexWords{{
    {U'\\', "\\textbackslash{}"},
    {U'{', "\\{"},
    {U'}', "\\}"},
    {U'$', "\\$"},
    {U'&', "\\&"},
    {U'#', "\\#"},
    {U'%', "\\%"},
    {U'_', "\\_"},
    {U'^', "\\textasciicircum{}"},
    {U'~', "\\textasciitilde{}"},
    {U'<', "$<$"},
    {U'>', "$>$"},
    {U'|', "$|$"},
    {U'−', "$-$"},
    {U'–', "--"},
    {U'—', "---"},
    {U'…', "\\ldots{}"},
    {U'±', "$\\pm$"},
    {U'×', "$\\times$"},
    {U'·', "$\\cdot$"},
    {U'≤', "$\\leq$"},
    {U'≥', "$\\geq$"},
    {U'≠', "$\\neq$"},
    {U'≈', "$\\approx$"},
    {U'∞', "$\\infty$"},
    {U'√', "$\\surd$"},
    {U'‖', "$\\|$"},
    {U'→', "$\\rightarrow$"},
    {U'°', "$^\\circ$"},
    {U'¹', "$^1$"},
    {U'²', "$^2$"},
    {U'³', "$^3$"},
    {U'⁻', "$^-$"},
    {U'½', "$\\frac12$"},
    {U'ᵀ', "$^\\top$"},
    {U'̂', "\\^{}"},
    {U'α', "$\\alpha$"},
    {U'β', "$\\beta$"},
    {U'γ', "$\\gamma$"},
    {U'δ', "$\\delta$"},
    {U'ε', "$\\varepsilon$"},
    {U'θ', "$\\theta$"},
    {U'λ', "$\\lambda$"},
    {U'µ', "$\\mu$"},
    {U'μ', "$\\mu$"},
    {U'ν', "$\\nu$"},
    {U'π', "$\\pi$"},
    {U'ρ', "$\\rho$"},
    {U'σ', "$\\sigma$"},
    {U'τ', "$\\tau$"},
    {U'φ', "$\\varphi$"},
    {U'χ', "$\\chi$"},
    {U'ω', "$\\omega$"},
    {U'Δ', "$\\Delta$"},
    {U'Φ', "$\\Phi$"},
    {U'Σ', "$\\Sigma$"},
}};

std::string pgf_point(CanvasPoint p) {
  return fmt::format("\\pgfqpoint{{{:.3f}bp}}{{{:.3f}bp}}", kPgfPoints * p.x, kPgfPoints * p.y);
}

std::string pgf_colour(std::uint32_t rgb) {
  const auto channel = [rgb](unsigned shift) { return static_cast<double>((rgb >> shift) & 0xFFu) / 255.0; };
  return fmt::format("{:.4f},{:.4f},{:.4f}", channel(16), channel(8), channel(0));
}

}  // namespace

std::string latex_words(std::string_view words) {
  std::string latex;
  for (std::size_t i = 0; i < words.size();) {
    const std::size_t start = i;
    const char32_t c = next_code_point(words, i);
    const auto* const known = std::ranges::find(kLatexWords, c, &std::pair<char32_t, const char*>::first);
    if (known != kLatexWords.end()) {
      latex += known->second;
    } else {
      latex += words.substr(start, i - start);
    }
  }
  return latex;
}

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
