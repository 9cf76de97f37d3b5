#pragma once

#include "core/record/block_layout.h"
#include "core/simd/aligned_vector.h"
#include "core/simd/block_map_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// A covariance of vehicle and map whose landmarks are uncorrelated with each other: P_rr (n_r×n_r), P_rf
/// (n_r×n_f) and one d×d block for each of N landmarks (theory, section 4, O(N) filter).
///
/// Never an n×n matrix: memory is n_r·d + d(d+1)/2 doubles a landmark, kept as arrays over the landmarks for
/// the kernels. n_r ≤ 3 and d ≤ 2.
class ArrowCovariance {
 public:
  using VehicleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
  using CrossMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 2>;     ///< n_r×d
  using LandmarkMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2, 2>;  ///< d×d

  /// No landmarks, and a vehicle of no variance. Throws std::invalid_argument for other n_r, d.
  explicit ArrowCovariance(Index vehicle = 3, Index landmark = 2);

  /// The blocks of a dense P that `layout` names; correlations between landmarks are not looked at.
  /// Throws std::invalid_argument for a P of another size.
  static ArrowCovariance of(MatrixRef P, const BlockLayout& layout);

  const BlockLayout& layout() const { return layout_; }
  Index landmarks() const { return layout_.landmarks; }
  Index state_dim() const { return layout_.state_dim(); }

  const VehicleMatrix& vehicle() const { return rr_; }
  void set_vehicle(const MatrixRef& P);  ///< n_r×n_r
  CrossMatrix cross(Index j) const;      ///< P_rf of landmark j
  void set_cross(Index j, const CrossMatrix& rf);
  LandmarkMatrix block(Index j) const;  ///< P of landmark j
  void set_block(Index j, const LandmarkMatrix& P);

  void append(const CrossMatrix& rf, const LandmarkMatrix& P);
  void reserve(Index landmarks);

  double trace() const { return rr_.trace() + trace_of_map(); }
  double trace_of_map() const;
  double variance(Index i) const;  ///< diagonal entry i of P
  Matrix dense() const;            ///< n×n, for tests and for what is written down of single runs

  /// For the kernels; valid until the next append.
  BlockMapArrays arrays();
  Index stride() const { return stride_; }  ///< landmarks that there is room for
  std::size_t doubles() const { return values_.capacity(); }

 private:
  std::size_t cross_at(Index a, Index c, Index j) const {
    return static_cast<std::size_t>((a * layout_.landmark + c) * stride_ + j);
  }
  std::size_t block_at(Index entry, Index j) const {
    return static_cast<std::size_t>((layout_.vehicle * layout_.landmark + entry) * stride_ + j);
  }
  Index array_count() const {
    return layout_.vehicle * layout_.landmark + layout_.landmark * (layout_.landmark + 1) / 2;
  }

  BlockLayout layout_;
  VehicleMatrix rr_;
  Index stride_ = 0;
  AlignedVector values_;
};

/// What an error e says of a covariance P.
struct ArrowNees {
  bool positive_definite = true;  ///< false: P, its states of zero variance left out, has no Cholesky factor
  double nees = 0.0;              ///< eᵀ P⁻¹ e over the states of non-zero variance
  Index dof = 0;                  ///< how many these are
};

/// NEES of e (n) by block elimination: the landmarks first, each by itself, the vehicle by its Schur
/// complement. O(N). Throws std::invalid_argument for an e of another length.
ArrowNees arrow_nees(VectorRef e, const ArrowCovariance& P);

}  // namespace credence::internal
