#pragma once

#include <cmath>

#include "core/linear_algebra/matrix_buffer.h"
#include "core/types.h"

namespace credence::internal {

/// A ← L with L Lᵀ = A, psd, which is given by its lower triangle: the Cholesky factor, with a column of
/// zeros where a pivot is rounding.
void semidefinite_root(Eigen::Ref<Matrix> A);

/// D ← X with X L = D, so that X L Lᵀ Xᵀ = D Dᵀ. Where a column of L is zero that of X is free, and is left
/// to whoever has put it into D.
void divide_by_root(Eigen::Ref<Matrix> D, const MatrixRef& L);

/// Moments of a function of l states by 2l sigma points, x ± √c L_j, L Lᵀ = P, c = α² l, of β = 2
/// ([Julier 2004]). With y± = f(x ± √c L_j) − f(x), D_j = (y₊ − y₋)/(2√c) and s_j = (y₊ + y₋)/2,
///
///   ȳ = f(x) + μ,   μ = Σ s_j/c,   cov y = D Dᵀ + curvature,
///   curvature = Σ_j s_j s_jᵀ/c + (β − α²) μ μᵀ,
///
/// a sum of like terms however small α is. Nothing is allocated once the sizes have been seen.
class UnscentedTransform {
 public:
  /// `deviation(step, y)` puts f(x ⊞ step) − f(x) into y, of m numbers. P: its lower triangle.
  template <class Deviation>
  void take(const MatrixRef& P, Index m, double alpha, Deviation deviation) {
    const Index l = P.rows();
    auto root = root_.resize(l, l);
    root = P;
    semidefinite_root(root);
    auto D = D_.resize(m, l), half_sums = half_sums_.resize(m, l);
    auto step = step_.resize(l), up = up_.resize(m), down = down_.resize(m);
    const double c = static_cast<double>(l) * alpha * alpha, root_c = std::sqrt(c);
    for (Index j = 0; j < l; ++j) {
      step = root_c * root.col(j);
      deviation(step_.vector(), up_.vector());
      step = -step;
      deviation(step_.vector(), down_.vector());
      D.col(j) = (up - down) / (2.0 * root_c);
      half_sums.col(j) = 0.5 * (up + down);
    }
    add_moments(c, alpha);
  }

  Eigen::Map<Matrix> root() { return root_.matrix(); }
  Eigen::Map<Matrix> D() { return D_.matrix(); }
  Eigen::Map<Vector> shift() { return shift_.vector(); }  ///< μ
  Eigen::Map<Matrix> curvature() { return curvature_.matrix(); }

 private:
  void add_moments(double c, double alpha);

  MatrixBuffer root_, D_, half_sums_, step_, up_, down_, shift_, curvature_;
};

}  // namespace credence::internal
