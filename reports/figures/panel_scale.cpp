#include "reports/figures/panel_scale.h"

#include <algorithm>
#include <cmath>

#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kFarOutside = 1e6;

}  // namespace

double share_of_axis(const Axis& axis, double value) {
  if (!std::isfinite(value) || (axis.log && value <= 0.0)) return kNaN;
  const auto [low, high] = axis.range;
  if (axis.log) return (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
  return (value - low) / (high - low);
}

double PanelScale::x(double value) const {
  const CanvasBox& box = layout_.box;
  return std::clamp(box.left + share_of_axis(layout_.x, value) * box.width(), -kFarOutside, kFarOutside);
}

double PanelScale::y(double value) const {
  const CanvasBox& box = layout_.box;
  return std::clamp(box.bottom - share_of_axis(layout_.y, value) * box.height(), -kFarOutside, kFarOutside);
}

std::vector<CanvasPath> PanelScale::curves(const FigureData& xs, const FigureData& ys) const {
  std::vector<CanvasPath> curves;
  bool open = false;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const CanvasPoint point{x(xs[i]), y(ys[i])};
    const bool usable = !std::isnan(point.x) && !std::isnan(point.y);
    if (usable && !open) curves.emplace_back();
    if (usable) curves.back().push_back(point);
    open = usable;
  }
  return curves;
}

}  // namespace credence::internal
