#include "core/manifold/trigonometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/simd/fused_multiply_add.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack_scalar.inc"
//
#include "core/simd/trigonometry_body.inc"

/// Sides that are infinite, no numbers, or too small or large for the errors of their products.
double arc_tangent_of_any_sides(double y, double x) {
  if (std::isnan(y) || std::isnan(x)) return y + x;
  double ay = std::abs(y), ax = std::abs(x);
  if (std::isinf(ay) || std::isinf(ax)) {
    ay = std::isinf(ay) ? 1.0 : 0.0;
    ax = std::isinf(ax) ? 1.0 : 0.0;
  } else if (x > 0.0 && ay < 0x1p-60 * ax) {
    return y / x;
  } else {
    const int exponent = std::ilogb(std::max(ay, ax));
    ay = std::scalbn(ay, -exponent);
    ax = std::scalbn(ax, -exponent);
    if (ay < 0x1p-60) ay = 0.0;
    if (ax < 0x1p-120) ax = 0.0;
  }
  return arc_tangent_lanes<LanePack>(std::copysign(ay, y), std::copysign(ax, x));
}

}  // namespace

SineCosine sine_cosine(double angle_rad) {
  if (!reducible<LanePack>(angle_rad)) angle_rad = std::remainder(angle_rad, 2.0 * std::numbers::pi);
  SineCosine both;
  sine_cosine_lanes<LanePack>(angle_rad, both.sine, both.cosine);
  return both;
}

double arc_tangent(double y, double x) {
  return has_plain_sides<LanePack>(y, x) ? arc_tangent_lanes<LanePack>(y, x) : arc_tangent_of_any_sides(y, x);
}

}  // namespace credence::internal
