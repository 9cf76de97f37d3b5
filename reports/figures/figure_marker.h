#pragma once

#include "reports/figures/canvas.h"
#include "reports/figures/figure.h"

namespace credence::internal {

/// Draws the marker of `series` at every place; with a light rim, it is seen on a dark ground too.
void paint_markers(const Series& series, const CanvasPath& places, Canvas& canvas, bool rim = false);

/// The corners of a box.
CanvasPath rectangle_path(const CanvasBox& box);

}  // namespace credence::internal
