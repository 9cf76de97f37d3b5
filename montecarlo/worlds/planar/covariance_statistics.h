#pragma once

#include <concepts>
#include <limits>
#include <vector>

#include "core/linear_algebra/panel_cholesky.h"
#include "core/linear_algebra/small_cholesky.h"
#include "core/types.h"

/// @file
/// All that the statistics of a planar filter read of its covariance P. A filter whose covariance is no dense
/// matrix brings its own overloads of these functions, in the namespace of its covariance.

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

/// The NEES of the whole state.
inline NeesValue joint_nees(const Vector& error, const Matrix& P, NeesSolver& solver) {
  return solver.solve(error, P);
}

/// The NEES of the first three states, such as a pose in the plane.
NeesValue pose_nees(const Vector& error, const Matrix& P, NeesSolver& solver);

/// Sums of variances.
struct PlanarTraces {
  double all = 0.0;        ///< tr P
  double position = 0.0;   ///< of x and y
  double landmarks = 0.0;  ///< of the map
};

/// Of the covariance of [x; y; heading; map].
PlanarTraces planar_traces(const Matrix& P);
/// Of its trace and the block of the pose.
PlanarTraces planar_traces(double trace, const Eigen::Matrix3d& pose);

/// P as a matrix, for who looks at a single run.
inline const Matrix& dense_covariance(const Matrix& P) { return P; }

/// A covariance that can be judged.
template <class Covariance>
concept PlanarCovariance = requires(const Covariance& P, const Vector& error, NeesSolver& solver) {
  { joint_nees(error, P, solver) } -> std::same_as<NeesValue>;
  { pose_nees(error, P, solver) } -> std::same_as<NeesValue>;
  { planar_traces(P) } -> std::same_as<PlanarTraces>;
  { dense_covariance(P) } -> std::convertible_to<Matrix>;
};

}  // namespace credence
