#pragma once

#include <array>
#include <utility>

#include "analysis/laws/correlation/whiteness.h"

namespace credence::internal {

/// Correlations at lags to 5,120 steps, in memory for sixty: of the values, and of the means of 16 and of 256
/// successive ones, by twenty lags each.
///
/// A mean of so many has the slow part of the values, and what is fast is averaged out of it. A block that
/// has values and missing ones is the mean of the values; what is left over at the end of a run is left out.
class LongLags {
 public:
  static constexpr Index kLags = 20, kOfBlock = 16;
  using Levels = std::array<LagProducts, 3>;  ///< of the values, and of blocks of 16 and of 256

  /// Throws std::invalid_argument unless dim ≥ 1.
  explicit LongLags(Index dim);
  explicit LongLags(Levels levels) : levels_(std::move(levels)) {}

  /// As those of LagProducts.
  void add_run(const LagSeries& run);
  void merge(const LongLags& other);
  LongLags about(const Vector& mean) const { return plus(-mean * mean.transpose()); }
  LongLags plus(const Matrix& of_each) const;

  Index dim() const { return levels_[0].dim(); }
  const LagProducts& of_values() const { return levels_[0]; }
  const Levels& levels() const { return levels_; }

 private:
  Levels levels_;
};

}  // namespace credence::internal
