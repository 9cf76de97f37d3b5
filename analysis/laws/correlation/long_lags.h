#pragma once

#include <array>
#include <cstddef>

#include "analysis/laws/correlation/whiteness.h"

namespace credence::internal {

/// Correlations at lags far beyond those of LagProducts, in as little memory: of the means of 16 and of 256
/// successive values, by twenty lags each, to 320 and 5,120 steps.
///
/// A mean of so many has the slow part of the values, and what is fast is averaged out of it. A block that
/// has values and missing ones is the mean of the values; what is left over at the end of a run is left out.
class LongLags {
 public:
  static constexpr Index kLags = 20, kOfBlock = 16;
  using Levels = std::array<LagProducts, 2>;  ///< of blocks of 16 and of 256

  /// Throws std::invalid_argument unless dim ≥ 1.
  explicit LongLags(Index dim);
  explicit LongLags(Levels levels);

  /// As those of LagProducts.
  void begin_run();
  void add(VectorRef u);
  void add_missing();
  void merge(const LongLags& other);
  LongLags about(const Vector& mean) const;

  const Levels& levels() const { return levels_; }

 private:
  /// The values of a block that is not full yet.
  struct Open {
    Vector sum;
    Index values = 0, steps = 0;
  };

  void count_step(std::size_t level);

  Levels levels_;
  std::array<Open, 2> open_;
};

}  // namespace credence::internal
