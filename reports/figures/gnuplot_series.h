#pragma once

#include <string>
#include <vector>

#include "reports/figures/figure.h"
#include "reports/figures/figure_decimation.h"
#include "reports/figures/figure_layout.h"

/// @file
/// The series of a panel in gnuplot's language: data blocks, and the parts of a plot command that draw them.

namespace credence {

/// "rgb '#rrggbb'".
std::string gnuplot_colour(std::uint32_t rgb);
/// Width, colour and dashes of a series' lines.
std::string gnuplot_line(const Series& series);
/// Shape, size and colour of a series' markers.
std::string gnuplot_marker(const Series& series);

/// Collects data blocks over all panels, and the elements of the plot command of the present panel.
class PlotWriter {
 public:
  /// Adds what draws `series`; text marks are labels and not drawn here.
  void add(const Series& series, const PanelLayout& layout);
  /// The elements added since the last call; when nothing could be drawn, one that draws nothing but makes
  /// gnuplot draw the axes.
  std::vector<std::string> take_elements(const PanelLayout& layout);
  bool has_elements() const { return !elements_.empty(); }
  const std::string& data_blocks() const { return data_; }

 private:
  void add_curves(const std::vector<CurvePiece>& pieces, const std::string& style);
  void add_line(const Series& series, const PanelLayout& layout, const std::string& style);
  void add_error_bars(const Series& series, const PanelLayout& layout);
  void add_band(const Series& series, const PanelLayout& layout);
  void add_polygons(const Series& series, const PanelLayout& layout);
  void add_heat_map(const Series& series, const PanelLayout& layout);
  void add_cells(const std::string& rows, const std::string& style);

  std::string data_;
  std::vector<std::string> elements_;
  int blocks_ = 0;
};

}  // namespace credence
