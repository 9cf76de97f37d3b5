#pragma once

#include "core/types.h"

namespace credence::internal {

/// P = L Lᵀ of a few states, with the bits of Eigen::LLT and none of what its expressions cost a matrix of so
/// few rows. Keeps its memory, so that a matrix of the same size allocates nothing.
class SmallCholesky {
 public:
  static constexpr Index kMost = 31;  ///< rows; Eigen goes on by blocks

  /// Factors P, n×n with n ≤ kMost, whose lower triangle is read; n³/6 multiply-adds. False where a pivot is
  /// not positive and finite; then nothing else has a meaning.
  bool compute(const MatrixRef& P);

  Index size() const { return L_.rows(); }
  double pivot(Index i) const { return L_(i, i); }  ///< L_ii
  /// L; above its diagonal stands anything.
  const Matrix& lower() const { return L_; }

  /// x ← L⁻¹ x, n.
  void solve_lower(Eigen::Ref<Vector> x) const;
  /// (P⁻¹)_ii, n; n³/6 multiply-adds.
  void inverse_diagonal(Vector& diagonal) const;

 private:
  Matrix L_;
};

}  // namespace credence::internal
