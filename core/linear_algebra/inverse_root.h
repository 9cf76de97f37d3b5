#pragma once

#include <vector>

#include "core/types.h"

namespace credence::internal {

/// R^{-1/2} of a symmetric positive definite R of unit diagonal, as what it does to a vector. By sums,
/// products, quotients and square roots alone, so that every machine has the same bits; exact to about ε
/// times the condition number of R. Keeps its memory.
///
/// Two and three rows in closed form; up to kFew a product of symmetric factors, one of each step of Newton's
/// method in the product form of Denman and Beavers ([Higham 2008], section 6.3), M ← ½ I + ¼ (g M + M⁻¹/g)
/// from R to I, g = √(tr M⁻¹/tr M) for its speed. Of more rows Q G Λ^{-1/2} Gᵀ Qᵀ, R = Q T Qᵀ by
/// Householder's reflections and T = G Λ Gᵀ by implicit QL ([Golub 2013], section 8.3), none of which is
/// multiplied out. Measured with callgrind, root and product: 1,700, 4,000, 30,000, 55,000 and 144,000
/// instructions of 4, 6, 11, 15 and 24 rows; Eigen::SelfAdjointEigenSolver 12,000, 23,000, 72,000, 134,000
/// and 353,000.
class InverseRoot {
 public:
  static constexpr Index kFew = 6;

  /// Of n×n numbers, all of them. False where R is singular, or so near it that an eigenvalue is not above 4
  /// n² ε; then nothing else has a meaning.
  bool compute(Index n, const double* R);
  /// x ← R^{-1/2} x.
  void multiply(double* x) const;

 private:
  struct Rotation {
    Index at = 0;  ///< of the numbers at, at + 1
    double c = 1.0, s = 0.0;
  };

  bool of_two();
  bool of_three();
  template <Index kSize>
  bool iterate();
  template <Index kSize>
  void multiply_factors(double* x) const;
  void reduce();
  static Index diagonalise(Index n, double* d, double* e, Rotation* rotations);
  void multiply_rotations(double* x) const;
  void reflect(Index k, double* x) const;

  Index size_ = 0;
  std::vector<double> A_{};        ///< R; M, or the vectors v of the reflections I − τ v vᵀ
  std::vector<double> factors_{};  ///< n×n each
  std::vector<double> tau_{}, work_{};
  std::vector<double> diagonal_{}, beside_{};  ///< of T; Λ^{-1/2} in the end
  std::vector<Rotation> rotations_{};
  Index count_ = 0;  ///< of the factors, or of the rotations
};

}  // namespace credence::internal
