#include "reports/figures/figure_decimation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

namespace credence::internal {
namespace {

using Kept = std::vector<std::size_t>;

void add_extremes(Kept& kept, const CanvasPath& points) {
  const auto index = [&](auto it) { return static_cast<std::size_t>(it - points.begin()); };
  for (const auto coordinate : {&CanvasPoint::x, &CanvasPoint::y}) {
    const auto [low, high] = std::ranges::minmax_element(points, {}, coordinate);
    kept.push_back(index(low));
    kept.push_back(index(high));
  }
}

CanvasPath chosen(const CanvasPath& points, Kept kept) {
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  CanvasPath path;
  for (const std::size_t i : kept) path.push_back(points[i]);
  return path;
}

// The directions in which a line from one point passes all points since within the tolerance.
class Sector {
 public:
  // Whether the line to `offset` does; narrows the sector by it if so.
  bool takes(double dx, double dy, double tolerance) {
    const double distance = std::hypot(dx, dy);
    // A line that turns back leaves the sector of its outward way only when it is far enough to be seen.
    if (distance < furthest_ - tolerance) return false;
    furthest_ = std::max(furthest_, distance);
    if (distance <= tolerance) return true;
    const double spread = std::asin(tolerance / distance);
    const double direction = std::atan2(dy, dx);
    if (!open_) {
      middle_ = direction;
      low_ = -spread;
      high_ = spread;
      open_ = true;
      return true;
    }
    const double turn = std::remainder(direction - middle_, 2.0 * std::numbers::pi);
    if (turn < low_ || turn > high_) return false;
    low_ = std::max(low_, turn - spread);
    high_ = std::min(high_, turn + spread);
    return true;
  }

 private:
  bool open_ = false;
  double furthest_ = 0.0;
  double middle_ = 0.0, low_ = 0.0, high_ = 0.0;
};

}  // namespace

CanvasPath thin_columns(const CanvasPath& curve) {
  Kept kept;
  for (std::size_t begin = 0; begin < curve.size();) {
    std::size_t end = begin + 1;
    std::size_t lowest = begin;
    std::size_t highest = begin;
    for (; end < curve.size() && std::floor(curve[end].x) == std::floor(curve[begin].x); ++end) {
      if (curve[end].y < curve[lowest].y) lowest = end;
      if (curve[end].y > curve[highest].y) highest = end;
    }
    kept.insert(kept.end(), {begin, lowest, highest, end - 1});
    begin = end;
  }
  return chosen(curve, std::move(kept));
}

CanvasPath thin_distances(const CanvasPath& curve) {
  if (curve.empty()) return {};
  constexpr double kHalfPixel = 0.5;
  Kept kept{0, curve.size() - 1};
  std::size_t last = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    if (std::hypot(curve[i].x - curve[last].x, curve[i].y - curve[last].y) < kHalfPixel) continue;
    kept.push_back(i);
    last = i;
  }
  add_extremes(kept, curve);
  return chosen(curve, std::move(kept));
}

CanvasPath thin_cloud(const CanvasPath& cloud) {
  if (cloud.empty()) return {};
  Kept kept;
  std::set<std::pair<double, double>> taken;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (taken.emplace(std::floor(cloud[i].x), std::floor(cloud[i].y)).second) kept.push_back(i);
  }
  add_extremes(kept, cloud);
  return chosen(cloud, std::move(kept));
}

CanvasPath straighten(const CanvasPath& curve, double tolerance) {
  if (curve.size() < 3) return curve;
  CanvasPath kept{curve.front()};
  Sector sector;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    if (sector.takes(curve[i].x - kept.back().x, curve[i].y - kept.back().y, tolerance)) continue;
    kept.push_back(curve[i - 1]);
    sector = {};
    sector.takes(curve[i].x - kept.back().x, curve[i].y - kept.back().y, tolerance);
  }
  kept.push_back(curve.back());
  return kept;
}

}  // namespace credence::internal
