#pragma once

#include <vector>

#include "reports/figures/canvas.h"
#include "reports/figures/figure_layout.h"

namespace credence::internal {

/// From the data of a panel to the canvas.
class PanelScale {
 public:
  explicit PanelScale(const PanelLayout& layout) : layout_(layout) {}

  /// The place of a value; NaN where its axis has none (not finite, or not positive on a log axis). Values
  /// far outside stay within ±1e6.
  double x(double value) const;
  double y(double value) const;

  /// The curve (x_i, y_i), broken at points without a place.
  std::vector<CanvasPath> curves(const FigureData& x, const FigureData& y) const;

 private:
  const PanelLayout& layout_;
};

/// Where `value` lies in the range of its axis: 0 at the low end, 1 at the high end; NaN where nowhere.
double share_of_axis(const Axis& axis, double value);

}  // namespace credence::internal
