#pragma once

#include "analysis/stability/ranks.h"

namespace credence::internal {

/// A stack of rows of n unknowns, kept as its triangular factor: O(n²) of memory, and of time for each row.
class ObservabilityStack {
 public:
  explicit ObservabilityStack(Index states);

  void add(const VectorRef& row);

  /// Rows that tell the same: at most n, in echelon form.
  Matrix rows();

  /// The rank; the directions that no row tells are n less this.
  RankDecision rank();

 private:
  void reduce();

  Index states_, rows_ = 0;
  Matrix stack_;  ///< the triangular factor over new rows
};

}  // namespace credence::internal
