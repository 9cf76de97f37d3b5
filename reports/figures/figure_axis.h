#pragma once

#include <vector>

#include "reports/figures/figure.h"

/// @file
/// Ranges and ticks of the axes of a panel, chosen before drawing: every output format then shows the same
/// axes, and margins can be computed from the labels.

namespace credence::internal {

struct AxisTick {
  double value;
  FigureText label;
};

struct Axis {
  AxisRange range;
  bool log = false;
  std::vector<AxisTick> ticks;
};

/// Ticks at round values for about `wanted` labels; on a log axis at decades, or at 1, 2, 5 times decades
/// where few decades are shown. whole: on a linear axis at whole numbers only.
Axis make_axis(AxisRange range, bool log, int wanted, bool whole = false);

/// Whether all abscissae are whole numbers, as those of steps: between them there is nothing.
bool has_whole_x(const Panel& panel);

/// Whether cells are drawn, so that the panel needs a colour bar and no room at its ends.
bool has_heat_map(const Panel& panel);

/// What the series of a panel need, with room at the ends; the panel's own range where it states one.
AxisRange x_range_of(const Panel& panel);
AxisRange y_range_of(const Panel& panel);
AxisRange colour_range_of(const Panel& panel);

/// Where the first tenth of the steps makes a linear vertical axis more than twice as long as the rest needs,
/// ends it there, and adds that to the caption. bounds_alone: of the start only bounds may lie beyond it.
void leave_out_start(Figure& figure, bool bounds_alone);

/// The edges of cells around increasing centres: midpoints (geometric ones on a log axis), mirrored at the
/// ends.
std::vector<double> cell_edges(const FigureData& centres, bool log);

/// Grows the shorter of two ranges about its middle until x and y have one scale in a box of the given shape.
void equalise(AxisRange& x, AxisRange& y, double width_over_height);

/// Room that the longest tick label takes, in canvas units.
double widest_label(const Axis& axis);

}  // namespace credence::internal
