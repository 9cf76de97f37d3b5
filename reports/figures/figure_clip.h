#pragma once

#include <vector>

#include "reports/figures/canvas.h"

/// @file
/// What of a curve or an area lies in the box of the axes. Cut before drawing, so that a file holds nothing
/// that is not seen and every viewer shows the same.

namespace credence::internal {

/// The parts of an open line inside `box` (Liang and Barsky, 1984); where the line leaves the box it is cut
/// on the border.
std::vector<CanvasPath> clip_line(const CanvasPath& line, const CanvasBox& box);

/// A closed area cut at the four sides of `box` (Sutherland and Hodgman, 1974); empty where nothing is
/// inside.
CanvasPath clip_area(CanvasPath outline, const CanvasBox& box);

bool is_inside(const CanvasPoint& point, const CanvasBox& box);

}  // namespace credence::internal
