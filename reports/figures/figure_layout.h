#pragma once

#include <vector>

#include "reports/figures/figure.h"
#include "reports/figures/figure_axis.h"

/// @file
/// Where everything of a figure goes. Lengths are in units of 1/12 of the label font's size; the origin is
/// the lower left corner of the canvas.

namespace credence {

inline constexpr double kFontUnits = 12.0;
inline constexpr double kColourBarWidth = 12.0;

/// The box of the axes in the canvas.
struct PlotBox {
  double left, right, bottom, top;
  double width() const { return right - left; }
  double height() const { return top - bottom; }
};

struct LegendEntry {
  std::size_t series;   ///< index in the panel
  double x, y;          ///< left end of the sample, middle of the line of text
  double sample_width;  ///< the words start one gap behind it
};

struct PanelLayout {
  PlotBox box;
  Axis x, y;
  Axis colour;  ///< of a heat map, else without ticks
  bool has_colour_bar = false;
  double colour_bar_x = 0.0, colour_label_x = 0.0;
  double y_label_x = 0.0;  ///< the middle of the vertical label's line
  double x_label_y = 0.0;
  double title_y = 0.0;
  std::vector<LegendEntry> legend;
};

struct FigureLayout {
  double width = 0.0, height = 0.0;
  std::vector<PanelLayout> panels;
};

/// Lays out a valid figure on a canvas of `width` units; the height follows from the content. Axes in one row
/// or column of the grid line up; legends stand below their axes, never over the data.
FigureLayout lay_out(const Figure& figure, double width);

/// Estimated width of `text` in the label font.
double text_width(const FigureText& text);

}  // namespace credence
