#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reports/figures/figure.h"
#include "reports/figures/paper_style.h"

/// @file
/// Figures as SVG for pages, and as files for papers.

namespace credence::internal {

/// One <svg> element to stand in a web page or a file. Throws std::invalid_argument (see validate).
std::string render_svg(const Figure& figure);

/// A panel as an <svg> element of its own, with the numbers in it (panel_data.h).
struct PanelDrawing {
  std::string svg, data;
};

/// A figure that was drawn.
struct Drawing {
  std::string svg, caption{};
  std::vector<std::filesystem::path> files{};  ///< those written
  std::vector<PanelDrawing> panels{};          ///< the same again, for a page to place as its width allows
  std::vector<double> column_widths{};         ///< of the columns of panels, in pixels
};

/// Draws all figures, several at a time, and makes the folder's `figures` with each as <name>.svg and the
/// like, in the formats of its style; of several panels each alone as panels/<name>-<number>. Throws
/// std::invalid_argument for an invalid figure, and OutputError when a file cannot be written.
std::vector<Drawing> draw_all(std::span<const Figure> figures, const ReportFolder& folder);

}  // namespace credence::internal
