#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/filters/arrow_covariance.h"
#include "core/inflation/batch_bound.h"
#include "core/inflation/rank_one_bound.h"
#include "core/simd/block_map_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// State and covariance of the O(N) filter: scalar updates whose inflation keeps the map block diagonal
/// (theory, sections 4 and 5), as sequential_update does it with a dense P.
///
/// What a step does to the correlation of the vehicle with a landmark that it does not measure is the same
/// n_r×n_r matrix for all landmarks: P_rf,j = T X_j, and likewise x_j = x⁰_j + X_jᵀ w. T and w are kept up to
/// date, and X of a large map is only read. Landmarks that are measured leave X: they are kept beside it
/// until `flush` brings everything together. Only the weights of the inflation ask for a pass over the map:
/// the norms of two scalar measurements in one, and another pass where the blocks change.
template <int kVehicle, int kLandmark>
class BlockMapState {
 public:
  using VehicleVector = Eigen::Matrix<double, kVehicle, 1>;
  using VehicleMatrix = Eigen::Matrix<double, kVehicle, kVehicle>;
  using LandmarkVector = Eigen::Matrix<double, kLandmark, 1>;
  using LandmarkMatrix = Eigen::Matrix<double, kLandmark, kLandmark>;
  using CrossMatrix = Eigen::Matrix<double, kVehicle, kLandmark>;

  /// A landmark that has been measured since the last flush.
  struct Measured {
    Index j = 0;                                     ///< its number in the state
    CrossMatrix cross = CrossMatrix::Zero();         ///< P_rf
    LandmarkMatrix block = LandmarkMatrix::Zero();   ///< P_jj
    LandmarkVector column = LandmarkVector::Zero();  ///< its part of P hᵀ, of the scalar at hand
    LandmarkVector change = LandmarkVector::Zero();  ///< of its position by the batch so far
    Index row = -1;  ///< of its L in the group at hand; −1: not measured by it
  };

  /// One scalar measurement, linearised at the prior: ν = h_r e_r + h_l e_l + noise of variance r.
  struct Scalar {
    Index measured = -1;  ///< index of the landmark as `measure` gave it; −1 for an anchor
    VehicleVector h_r;
    LandmarkVector h_l;
    double nu = 0.0, r = 0.0;
  };

  BlockMapState() : P_(kVehicle, kLandmark), kernel_(&block_map_kernel(kVehicle, kLandmark)) {}

  /// Takes x (n) and P; the sizes match.
  void reset(VectorRef x, ArrowCovariance P);

  Index landmarks() const { return P_.landmarks(); }
  const VehicleMatrix& vehicle_covariance() const { return rr_; }
  VehicleVector pose() const { return x_.template head<kVehicle>(); }
  void set_pose(const VehicleVector& pose) { x_.template head<kVehicle>() = pose; }
  double trace() const { return rr_.trace() + map_trace_; }

  /// Position of landmark j as it is now. O(1).
  LandmarkVector position(Index j) const;

  /// P_rr ← F P_rr Fᵀ + noise, P_rf ← F P_rf. O(landmarks measured since the last flush).
  void predict(const VehicleMatrix& F, const VehicleMatrix& noise);

  /// The index of landmark j among those measured, which it joins if it is none; good until the next flush.
  Index measure(Index j);
  const Measured& measured(Index i) const { return measured_[static_cast<std::size_t>(i)]; }
  Index measured_count() const { return static_cast<Index>(measured_.size()); }

  /// Flushes where it pays: each measured landmark costs every later step some 50 ns, a flush some 2 ns for
  /// each of the map; with a new one measured at each step the sum is least at √(N/14) of them.
  void flush_if_crowded() {
    if (14 * measured_count() * measured_count() > landmarks()) flush();
  }

  /// One batch: scalar by scalar, O(N) for each two, or by MapBound::batch, kLandmark scalars a landmark, in
  /// groups of at most kMostBatchScalars, O(N) for each. False, with the state not to be used, when a scalar
  /// innovation variance or the covariance of a group is not positive. With a `gain` (n×scalars) that of the
  /// batch is written there.
  bool correct(std::span<const Scalar> scalars, MapBound bound, Matrix* gain);

  /// A new landmark with P_jx = J P_rx and the variance `own`; its correlations with the map are removed by
  /// the inflation of least trace, which for a star is the pairwise one. O(N).
  void append(const LandmarkVector& position, const Eigen::Matrix<double, kLandmark, kVehicle>& J,
              const LandmarkMatrix& own);

  /// Applies what is pending. O(N). Then x() and covariance() are up to date.
  void flush();
  const Vector& x() const { return x_; }
  const ArrowCovariance& covariance() const { return P_; }

  /// Memory that grows with the map.
  std::size_t bytes() const;

 private:
  /// One scalar of a pass.
  struct Step {
    VehicleVector column;  ///< vehicle part of P hᵀ
    double variance = 0.0;
    double excess = 0.0;  ///< of the bound, over √s; 0: the map's blocks stay
  };

  /// A group of scalars, of c in all, as one correction takes it.
  struct Group {
    using Columns =
        Eigen::Matrix<double, kVehicle, Eigen::Dynamic, kVehicle == 1 ? Eigen::RowMajor : Eigen::ColMajor,
                      kVehicle, kMostBatchScalars>;
    Columns vehicle;  ///< n_r×c: what the group takes from P_rr
    Columns g;        ///< n_r×c: a landmark that it does not measure has L_j = P_rf,jᵀ g
    BatchRows rows;   ///< kd×c: L of the landmarks it measures
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostBatchScalars, 1> move;  ///< whitened innovation
  };

  bool correct_group(std::span<const Scalar> scalars, Index first, Matrix* gain);
  bool prepare(std::span<const Scalar> scalars, Group& group, Matrix* combination);
  void inflate_group(const Group& group);
  void apply(const Group& group);
  void add_to_gain(const Group& group, const Matrix& combination, Matrix& gain) const;
  bool correct_pass(std::span<const Scalar> scalars, MapBound bound, Index first, Matrix* gain);
  bool prepare(const Scalar& scalar, Step& step);
  VehicleVector direction(int i) const;
  void set_direction(int i, const VehicleVector& g);
  void compute_norms() { kernel_->norms(P_.arrays(), directions_, reciprocals_.data(), norms_); }
  void inflate_blocks(std::span<Step> steps);
  Index largest_of_map(int i) const;
  void settle_bound(const Scalar& scalar, std::span<Step> steps, int i);
  void apply(const Scalar& scalar, const Step& step, int i);
  void add_to_gain(const Scalar& scalar, const Step& step, int i, Index row, Matrix& gain) const;
  void make_room();

  Vector x_;
  ArrowCovariance P_;  ///< map: X and the blocks; the vehicle's own block is rr_
  VehicleMatrix rr_ = VehicleMatrix::Zero();
  VehicleMatrix T_ = VehicleMatrix::Identity();
  VehicleVector w_ = VehicleVector::Zero();
  double map_trace_ = 0.0;
  bool pending_ = false;  ///< T is not the identity or w not zero

  std::vector<Measured> measured_;
  std::vector<Index> group_;               ///< indices in measured_ of the landmarks that a group measures
  std::vector<std::int32_t> measured_at_;  ///< by landmark, −1 if not measured
  VehicleVector pose_change_;

  const BlockMapKernel* kernel_;
  BlockMapDirections directions_;
  BlockMapNorms norms_[kMaxDirections];
  AlignedVector reciprocals_, shift_;
};

extern template class BlockMapState<3, 2>;
extern template class BlockMapState<1, 1>;

}  // namespace credence::internal
