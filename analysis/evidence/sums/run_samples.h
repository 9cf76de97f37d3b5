#pragma once

#include "core/types.h"

namespace credence::internal {

/// Errors of a run over their σ, and how large σ is, evenly over it: every 2^k-th, k as small as kMost of
/// them allow.
class RunSamples {
 public:
  static constexpr Index kMost = 2048, kLargest = 24;

  /// The next row, of at most kLargest states with σ > 0, as many as in the rows before; others are left out.
  void add(const Vector& error, const Vector& variance);

  /// One a column.
  auto errors() const { return samples_.leftCols(count_); }
  /// ln σ² of each, the mean over the states.
  auto log_variances() const { return log_variances_.head(count_); }
  /// At most so many errors, evenly; `most`: kMost by a power of two.
  Matrix errors(Index most) const;
  Index count() const { return count_; }
  /// That they are of.
  Index rows() const { return rows_; }

 private:
  Matrix samples_{};
  Vector log_variances_{};
  Index rows_ = 0, every_ = 1, count_ = 0;
};

}  // namespace credence::internal
