#pragma once

#include <vector>

#include "core/linear_algebra/inverse_root.h"
#include "core/types.h"

namespace credence::internal {

/// Whitens errors by the symmetric root of their correlation matrix, u = R^{-1/2} D⁻¹ e with P = D R D and D
/// the standard deviations: ZCA-cor of [Kessy 2018]. Each u_i belongs to a state, P permuted gives u
/// permuted, units change nothing, and errors that P claims to be uncorrelated with all others are divided by
/// their σ.
class CorrelationWhitening {
 public:
  /// Of P, n×n, whose lower triangle is read; nothing is computed where it is that of the last call. False
  /// where a variance is not positive or R singular (InverseRoot); then nothing else has a meaning.
  bool compute(const MatrixRef& P);
  /// u of an error of n numbers.
  void whiten(const VectorRef& error, Vector& u) const;

 private:
  template <Index kSize>
  bool compute(const double* P, Index stride);

  bool whitens_ = false;
  Index size_ = 0;
  std::vector<double> P_{};  ///< of the last call, its lower triangle by columns
  std::vector<double> R_{}, inverse_deviation_{};
  InverseRoot root_{};
};

}  // namespace credence::internal
