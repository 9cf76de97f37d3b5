#pragma once

#include "reports/figures/canvas.h"
#include "reports/figures/figure.h"
#include "reports/figures/figure_layout.h"

namespace credence::internal {

/// Draws a valid figure as it was laid out: grid, series, axes, texts, legends, colour bars.
void paint_figure(const Figure& figure, const FigureLayout& layout, Canvas& canvas);

/// Draws one panel of it alone, at its place.
void paint_panel(const Panel& panel, const PanelLayout& layout, Canvas& canvas);

}  // namespace credence::internal
