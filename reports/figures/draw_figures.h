#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reports/figures/figure.h"

/// @file
/// Figures as SVG for pages and as PDF for papers.

namespace credence {

/// One <svg> element to stand in a web page or a file. Throws std::invalid_argument (see validate).
std::string render_svg(const Figure& figure);

/// The bytes of a PDF file of one page, as wide as one column of a paper (3.5 in) for one column of panels,
/// else as two (7.16 in). Throws like render_svg.
std::string render_pdf(const Figure& figure);

/// A panel as an <svg> element of its own, with the numbers in it (panel_data.h).
struct PanelDrawing {
  std::string svg, data;
};

/// A figure that was drawn.
struct Drawing {
  std::string svg;
  std::filesystem::path svg_file{}, pdf_file{};  ///< those written, if a folder was given
  std::vector<PanelDrawing> panels{};            ///< the same again, for a page to place as its width allows
  std::vector<double> column_widths{};           ///< of the columns of panels, in pixels
};

/// Draws all figures, several at a time; with `folder`, which must exist, each also as <name>.svg and
/// <name>.pdf in it, and each panel of several alone as panels/<name>-<number>.pdf. Throws OutputError when a
/// file cannot be written and std::invalid_argument for an invalid figure.
std::vector<Drawing> draw_all(std::span<const Figure> figures, const std::filesystem::path& folder = {});

}  // namespace credence
