#pragma once

#include "core/linear_algebra/mirror.h"
#include "core/types.h"

namespace credence::internal {

/// Scalar measurements that one batch bound takes at most; more are taken in several.
inline constexpr Index kMostBatchScalars = 32;

/// Rows of the landmarks that a batch measures, kd×c or kd×kd.
using BatchRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostBatchScalars,
                                kMostBatchScalars>;

/// How many of `scalars` are taken at once: an even number, so that range and bearing stay together.
Index batch_group(Index scalars);

/// Orthonormal columns, c×r, whose span holds the rows of G (r×c). With fewer scalars than r the last are
/// zero.
template <int r>
using BatchBasis = Eigen::Matrix<double, Eigen::Dynamic, r, Eigen::ColMajor, kMostBatchScalars, r>;
template <int r>
BatchBasis<r> batch_basis(const Eigen::Ref<const Matrix>& G);

/// What the bound asks of the landmarks that the batch does not measure: with C_j = L_j Q, σ_j = ‖C_j‖, the
/// sums Σ σ_j and Σ C_jᵀ C_j / σ_j.
template <int r>
struct BatchOthers {
  double norms = 0.0;
  Eigen::Matrix<double, r, r> squares = Eigen::Matrix<double, r, r>::Zero();

  /// A landmark of rows C (d×r).
  template <typename Rows>
  void add(const Rows& C) {
    const double sigma = C.norm();
    norms += sigma;
    if (sigma > 0.0) squares += C.transpose() * C / sigma;
  }
};

/// A bound in O(N) for a map that is block diagonal minus what a batch of c scalars took, D − L Lᵀ (theory,
/// section 4, "A whole batch in O(N)").
///
/// Landmarks that are not measured have L_j = X_jᵀ G with G r×c, r = n_r. For Θ that is zero beside the row
/// space of G and 0 ≺ Θ ⪯ I in it, ‖a + b‖² ≥ aᵀ(I − Θ)a − bᵀ(Θ⁻¹ − I)b parts those that are measured from
/// all others. The former are a small problem, D_j + E_j − L_j (I − Θ) L_jᵀ with E by block ascent, checked
/// by a Cholesky factorisation; each of the others grows by C_j S Sᵀ C_jᵀ / σ_j, S being `spread`.
template <int r, int d>
struct BatchBound {
  bool lowers = false;  ///< the trace of the map falls, by `gain`; otherwise D is to stay as it is
  double gain = 0.0;
  Eigen::Matrix<double, d, Eigen::Dynamic, d == 1 ? Eigen::RowMajor : Eigen::ColMajor, d, kMostBatchScalars>
      changes;  ///< of the blocks of the landmarks measured, side by side
  Eigen::Matrix<double, r, r> spread = Eigen::Matrix<double, r, r>::Zero();

  /// What a landmark of rows C that is not measured grows by; nothing for C = 0.
  Eigen::Matrix<double, d, d> growth(const Eigen::Matrix<double, d, r>& C) const {
    const double sigma = C.norm();
    if (!(sigma > 0.0)) return Eigen::Matrix<double, d, d>::Zero();
    const Eigen::Matrix<double, d, r> root = C * spread;
    Eigen::Matrix<double, d, d> growth = root * root.transpose() / sigma;
    mirror_lower(growth);
    return growth;
  }
};

/// `L` (kd×c) are the rows of the k landmarks measured, `Q` the basis that `others` was taken in, and
/// `map_trace` is tr D, by whose rounding a gain is no gain. O(k² d² (c + k d)), no allocation. r and d are 3
/// and 2, or 1 and 1, kd and c at most kMostBatchScalars.
template <int r, int d>
BatchBound<r, d> batch_bound(const BatchRows& L, const BatchBasis<r>& Q, const BatchOthers<r>& others,
                             double map_trace);

}  // namespace credence::internal
