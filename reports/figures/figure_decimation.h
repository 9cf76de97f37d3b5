#pragma once

#include <cstddef>
#include <vector>

/// @file
/// Fewer points where a figure cannot show more. What the eye would see stays: extremes are never dropped.

namespace credence {

/// A run of points between breaks, in data coordinates.
struct CurvePiece {
  std::vector<double> x, y;
};

/// Splits at points that are not finite (or not positive where `log_x`, `log_y`).
std::vector<CurvePiece> finite_pieces(const std::vector<double>& x, const std::vector<double>& y, bool log_x,
                                      bool log_y);

/// A box of pixels and the data range it shows (already as logarithms on log axes).
struct PixelBox {
  double x_low, x_high, y_low, y_high;
  int width, height;
};

/// Indices to keep of a curve with increasing x: for every pixel column its first, lowest, highest and last
/// point.
std::vector<std::size_t> keep_by_column(const std::vector<double>& x, const std::vector<double>& y,
                                        const PixelBox& box);

/// Indices to keep of a curve that may turn back: points at least half a pixel from the last one kept, both
/// ends and the extremes in x and y.
std::vector<std::size_t> keep_by_distance(const std::vector<double>& x, const std::vector<double>& y,
                                          const PixelBox& box);

/// Indices to keep of a cloud: one point for each pixel, and the extremes in x and y.
std::vector<std::size_t> keep_by_pixel(const std::vector<double>& x, const std::vector<double>& y,
                                       const PixelBox& box);

}  // namespace credence
