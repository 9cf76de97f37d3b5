#pragma once

#include <string>

#include "reports/figures/figure.h"
#include "reports/figures/figure_layout.h"

/// @file
/// The numbers behind a drawn panel, for the script of a page (html_script.h): what stands under the mouse,
/// and what belongs to an entry of the legend.

namespace credence::internal {

/// One JSON object without the characters < and &:
///
///   box: left, right, top, bottom of the axes in units of the drawing
///   x, y: low, high, and 1 for a logarithmic axis
///   title, xLabel, yLabel, valueLabel: words
///   mode: "column" (values at one x), "near" (the nearest point, for curves in the plane) or "cells"
///   columns: abscissae that series share, as numbers or as {from, by, n}
///   series: i (in the panel), n(ame), c(olour), x (a column), y, and l(ower) and u(pper) of bands and error
///     bars; two lines of which only the first is named are the lower and upper end of a band
///   parts: for each named series which drawn ones it stands for
///   cells: x, y, their edges xe, ye, names xn, yn where the panel has them, and v, row by row
///
/// Five significant digits; of longer curves every n-th point, so that a page stays small.
std::string panel_data(const Panel& panel, const PanelLayout& layout);

/// For each series of a panel the one under whose name it is shown: itself, the named one that it completes
/// (the other end of a band, the line through error bars), or itself without a name.
std::vector<std::size_t> leading_series(const Panel& panel);

}  // namespace credence::internal
