#pragma once

#include "reports/figures/canvas.h"

/// @file
/// Fewer points where a figure cannot show more. What the eye would see stays: extremes are never dropped.
/// A canvas unit is one pixel of a page.

namespace credence::internal {

/// Of a curve with increasing x: for every pixel column its first, lowest, highest and last point.
CanvasPath thin_columns(const CanvasPath& curve);

/// Of a curve that may turn back: points at least half a pixel from the last one kept, both ends and the
/// extremes in x and y.
CanvasPath thin_distances(const CanvasPath& curve);

/// Of a cloud: one point for each pixel, and the extremes in x and y.
CanvasPath thin_cloud(const CanvasPath& cloud);

/// Leaves out points that lie within `tolerance` of the straight line between those kept before and behind
/// them. Ends stay. O(n).
CanvasPath straighten(const CanvasPath& curve, double tolerance);

}  // namespace credence::internal
