#include "reports/figures/figure_decimation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <unordered_set>

namespace credence {
namespace {

double pixel_x(double x, const PixelBox& box) {
  return (x - box.x_low) / (box.x_high - box.x_low) * box.width;
}
double pixel_y(double y, const PixelBox& box) {
  return (y - box.y_low) / (box.y_high - box.y_low) * box.height;
}

std::size_t index_of(std::vector<double>::const_iterator it, const std::vector<double>& values) {
  return static_cast<std::size_t>(std::distance(values.begin(), it));
}

void add_extremes(std::vector<std::size_t>& kept, const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  kept.push_back(index_of(low, values));
  kept.push_back(index_of(high, values));
}

void sort_unique(std::vector<std::size_t>& kept) {
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
}

}  // namespace

std::vector<CurvePiece> finite_pieces(const std::vector<double>& x, const std::vector<double>& y, bool log_x,
                                      bool log_y) {
  std::vector<CurvePiece> pieces;
  bool open = false;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool usable =
        std::isfinite(x[i]) && std::isfinite(y[i]) && (!log_x || x[i] > 0.0) && (!log_y || y[i] > 0.0);
    if (usable && !open) pieces.emplace_back();
    if (usable) {
      pieces.back().x.push_back(x[i]);
      pieces.back().y.push_back(y[i]);
    }
    open = usable;
  }
  return pieces;
}

std::vector<std::size_t> keep_by_column(const std::vector<double>& x, const std::vector<double>& y,
                                        const PixelBox& box) {
  std::vector<std::size_t> kept;
  const auto column_of = [&](std::size_t i) { return std::floor(pixel_x(x[i], box)); };
  for (std::size_t begin = 0; begin < x.size();) {
    std::size_t end = begin + 1;
    std::size_t lowest = begin;
    std::size_t highest = begin;
    for (; end < x.size() && column_of(end) == column_of(begin); ++end) {
      if (y[end] < y[lowest]) lowest = end;
      if (y[end] > y[highest]) highest = end;
    }
    kept.insert(kept.end(), {begin, lowest, highest, end - 1});
    begin = end;
  }
  sort_unique(kept);
  return kept;
}

std::vector<std::size_t> keep_by_distance(const std::vector<double>& x, const std::vector<double>& y,
                                          const PixelBox& box) {
  if (x.empty()) return {};
  constexpr double kHalfPixel = 0.5;
  std::vector<std::size_t> kept{0, x.size() - 1};
  std::size_t last = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double moved =
        std::hypot(pixel_x(x[i], box) - pixel_x(x[last], box), pixel_y(y[i], box) - pixel_y(y[last], box));
    if (moved < kHalfPixel) continue;
    kept.push_back(i);
    last = i;
  }
  add_extremes(kept, x);
  add_extremes(kept, y);
  sort_unique(kept);
  return kept;
}

std::vector<std::size_t> keep_by_pixel(const std::vector<double>& x, const std::vector<double>& y,
                                       const PixelBox& box) {
  if (x.empty()) return {};
  std::vector<std::size_t> kept;
  std::unordered_set<std::int64_t> taken;
  for (std::size_t i = 0; i < x.size(); ++i) {
    // Points far outside share a cell at the border; they are not drawn anyway.
    const double column = std::clamp(std::floor(pixel_x(x[i], box)), -1.0, box.width + 1.0);
    const double row = std::clamp(std::floor(pixel_y(y[i], box)), -1.0, box.height + 1.0);
    const auto cell = static_cast<std::int64_t>(row) * (box.width + 4) + static_cast<std::int64_t>(column);
    if (taken.insert(cell).second) kept.push_back(i);
  }
  add_extremes(kept, x);
  add_extremes(kept, y);
  sort_unique(kept);
  return kept;
}

}  // namespace credence
