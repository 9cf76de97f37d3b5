#pragma once

#include <cstdint>
#include <vector>

#include "reports/figures/canvas.h"
#include "reports/figures/figure.h"
#include "reports/figures/panel_scale.h"

namespace credence::internal {

/// Draws the series of one panel within its axes.
class SeriesPainter {
 public:
  SeriesPainter(const PanelLayout& layout, Canvas& canvas)
      : layout_(layout), scale_(layout), canvas_(canvas) {}

  /// Words will not stand on the markers of this panel, if there is room, and rather not on its bars.
  void keep_clear(const Panel& panel);
  void paint(const Series& series);
  /// What stands for `series` in the legend: its line, marker or area.
  void paint_sample(const Series& series, const LegendEntry& entry);
  /// Whether anything of the series painted so far could be seen.
  bool has_painted() const { return has_painted_; }

 private:
  /// The curves (x_i, y_i), as far to the right as the series stands aside.
  std::vector<CanvasPath> curves(const Series& series, const FigureData& x, const FigureData& y) const;
  void lines(const Pen& pen, const std::vector<CanvasPath>& curves);
  void markers(const Series& series, const std::vector<CanvasPath>& places);
  void areas(const Series& series, const std::vector<CanvasPath>& outlines);
  void curve(const Series& series);
  void error_bars(const Series& series);
  void band(const Series& series);
  void polygons(const Series& series);
  void words(const Series& series);
  void cells(const Series& series);

  /// Of a heat map.
  struct Cell {
    CanvasBox box;
    std::uint32_t rgb = 0;
  };

  struct WordsPlace {
    CanvasPoint at;
    TextAnchor anchor;
    CanvasBox box;
    double cost = 0.0;  ///< more, the further from the point
  };

  /// Where words of this width may stand, the usual place first.
  std::vector<WordsPlace> places_beside(CanvasPoint point, double width) const;
  /// To the right of and above `point`; where other words stand there, in another corner or, led to by a
  /// line, in the nearest free place around it.
  WordsPlace beside(CanvasPoint point, double width) const;
  /// Nothing where the words are near enough.
  static CanvasPath lead_to(const WordsPlace& place, CanvasPoint point);

  const PanelLayout& layout_;
  PanelScale scale_;
  Canvas& canvas_;
  std::vector<Cell> cells_;                ///< painted so far
  std::vector<CanvasBox> words_;           ///< painted so far
  std::vector<CanvasBox> markers_, bars_;  ///< of all series, to be kept clear of words
  bool has_painted_ = false;
};

}  // namespace credence::internal
