#pragma once

#include <cstdint>

#include "core/types.h"

namespace credence::internal {

/// Count, mean and scatter Σ (u − ū)(u − ū)ᵀ of vectors: additive (Chan), merged in index order for the same
/// bits.
struct VectorMoments {
  std::int64_t count = 0;
  Vector mean;     ///< m; empty before the first value
  Matrix scatter;  ///< m×m

  /// Throws std::invalid_argument for a dimension other than that of the first value.
  void add(VectorRef u);
  void merge(const VectorMoments& other);

 private:
  Vector delta_{};  ///< of the last value, so that adding allocates nothing
};

}  // namespace credence::internal
