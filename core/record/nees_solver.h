#pragma once

#include <limits>
#include <vector>

#include "core/linear_algebra/panel_cholesky.h"
#include "core/linear_algebra/small_cholesky.h"
#include "core/types.h"

namespace credence {

/// A NEES with its dof.
struct NeesValue {
  double value = 0.0;
  Index dof = -1;  ///< −1: P, its zero-variance states left out, has no Cholesky factor
};

/// eᵀ P⁻¹ e over the states whose variance is not zero; reads the lower triangle of P. Allocates only where
/// the number of states has changed.
class NeesSolver {
 public:
  NeesValue solve(const VectorRef& error, const MatrixRef& P);

  /// Of the last solve: L⁻¹ e, L_ii, ln det P and (P⁻¹)_ii, of the states of non-zero variance.
  const Vector& whitened() const { return whitened_; }
  double pivot(Index i) const { return wide_ ? panels_.pivot(i) : small_.pivot(i); }
  double log_determinant() const;
  const Vector& inverse_diagonal();

  /// Of the last solve, of an S: tr(S⁻¹ R)/m with R of pieces of these variances.
  double noise_share(const std::vector<double>& variances);
  /// The same with this R; NaN where it is of other components than those of non-zero variance.
  double noise_share(const MatrixRef& S, const MatrixRef& R);

  /// Of the last solve, whether rounding has left every pivot of P, all of whose variances are positive.
  bool well_conditioned(const MatrixRef& P) const;

  /// Further solves serve `without_lead`: the NEES of all but the first `lead` states, of the solve of a P of
  /// full rank. Of u = L⁻¹ e it is what the least squares of G c leave, G = L⁻¹ [I; 0].
  void keep_lead(Index lead) { lead_ = lead; }
  double without_lead() const;

  /// L_ii² of an n×n covariance is beyond rounding where it is larger than this times the variance.
  static constexpr double least_pivot(Index n) {
    return 100.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  }

 private:
  bool factor(const VectorRef& error, const MatrixRef& P);

  bool wide_ = false;
  Index lead_ = 0;
  Matrix lead_rows_;               ///< lead×n: [I 0]
  internal::SmallCholesky small_;  ///< of what is not wide
  internal::PanelCholesky panels_;
  Vector inverse_diagonal_;
  Vector whitened_;
  std::vector<Index> kept_;
  Matrix P_kept_;
};

}  // namespace credence
