#pragma once

#include "core/types.h"

namespace credence::internal {

/// Sums of the rows of a run over successive groups of them, in bounded memory: each group has as many rows,
/// a power of two, and of more than kMost groups two become one.
class GroupSums {
 public:
  static constexpr Index kMost = 64;

  /// Whether the next row begins a group.
  bool begins() const { return (rows_ & (rows_of_group_ - 1)) == 0; }
  /// Whether groups are joined before it.
  bool joins() const { return groups_ == kMost && begins(); }
  /// The next row, of `dim` numbers as all others: the sum that it is to be added to.
  Eigen::Map<Vector> next(Index dim);

  Index rows() const { return rows_; }
  Index groups() const { return groups_; }
  Index rows_of_group() const { return rows_of_group_; }
  auto of_group(Index g) const { return sums_.col(g); }

 private:
  Matrix sums_;  ///< a column of each group
  Index groups_ = 0, rows_ = 0, rows_of_group_ = 1;
};

}  // namespace credence::internal
