#pragma once

#include <vector>

#include "reports/figures/canvas.h"
#include "reports/figures/figure.h"
#include "reports/figures/figure_axis.h"

/// @file
/// Where everything of a figure goes, in canvas units from the upper left corner to the right and down.

namespace credence::internal {

inline constexpr double kColourBarWidth = 12.0;

/// What stands for a series in a legend.
struct LegendSample {
  bool area = false, line = false, outline = false, marker = false;
};

LegendSample legend_sample(const Series& series);

struct LegendEntry {
  std::size_t series;   ///< index in the panel
  double x, y;          ///< left end of the sample, middle of the line of text
  double sample_width;  ///< the words start one gap behind it
};

struct PanelLayout {
  CanvasBox box;   ///< of the axes
  CanvasBox cell;  ///< of everything: axes, labels, legend
  Axis x, y;
  Axis colour;  ///< of a heat map, else without ticks
  ColourScale colour_scale = ColourScale::sequential;
  bool has_colour_bar = false;
  double colour_bar_x = 0.0, colour_label_x = 0.0;
  double y_label_x = 0.0;  ///< the middle of the vertical label's line
  double x_label_y = 0.0;
  double title_y = 0.0;             ///< heights of texts are those of the middle of their line
  std::vector<LegendEntry> legend;  ///< none where the panels before have told the same
};

struct FigureLayout {
  double width = 0.0, height = 0.0;
  std::vector<PanelLayout> panels;
};

/// Lays out a valid figure on a canvas of `width` units; the height follows from the content. Axes in one row
/// or column of the grid line up; legends stand below their axes, never over the data, and name what has
/// data. A panel whose legend would tell nothing that the last one before it does not has none.
FigureLayout lay_out(const Figure& figure, double width);

}  // namespace credence::internal
