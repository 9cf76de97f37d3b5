#pragma once

#include "core/linear_algebra/panel_cholesky.h"
#include "core/simd/aligned_vector.h"
#include "core/simd/panel_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// The dense covariance of a vehicle and a map, whose corrections pass over the map together.
///
/// P ← P − W Wᵀ is done at once in the columns of the vehicle and in the variances, O(n m). In those of the
/// map, n² m/2 multiply-adds, it waits for others until kMostWaiting columns of W are there or P is read:
/// what limits the pass then is arithmetic, and not the memory that P is in. Every element takes its terms in
/// the order of the corrections, so that no bit depends on who reads P when. To read applies what waits;
/// hence one object belongs to one thread.
class DelayedCovariance {
 public:
  static constexpr Index kMostWaiting = 16;  ///< columns of W

  /// `vehicle` states come first.
  explicit DelayedCovariance(Index vehicle, InstructionSet set = best_instruction_set())
      : vehicle_(vehicle), kernel_(&panel_kernel(set)) {}

  /// Starts with P, n×n, n >= vehicle, whose lower triangle counts.
  void set(const MatrixRef& P);

  Index size() const { return P_.rows(); }  ///< n
  /// The vehicle's columns, n×vehicle, the block of the vehicle whole.
  auto vehicle_columns() { return columns_.topRows(size()); }
  auto vehicle_columns() const { return columns_.topRows(size()); }
  /// To be called after vehicle_columns() were changed.
  void vehicle_changed();

  auto variances() const { return variances_.head(size()); }
  /// P_11 + … + P_nn, summed in this order.
  double trace() const;

  /// Columns of the map from `first` on, n×count, into `to` of whole_panels(n) rows and as many columns.
  void copy_columns(Index first, Index count, Eigen::Map<Matrix> to) const;

  /// P ← P − W Wᵀ with the W of a factor, of n rows. Throws std::invalid_argument for another number.
  void downdate(const PanelCholesky& factor);

  /// New states: their covariances with all others, `cross` rows × n, and with each other, `own`, symmetric.
  void append(const MatrixRef& cross, const MatrixRef& own);

  /// P, n×n, symmetric to the last bit unless change() left it otherwise.
  const Matrix& whole() const;
  /// P, n×n, of which the lower triangle counts: what whole() costs but for the mirror.
  const Matrix& lower() const;

  /// Has `change(P)` change P as a whole, and returns what that returns.
  template <class Change>
  auto change(Change change) {
    whole();
    auto result = change(P_);
    take_vehicle();
    return result;
  }

 private:
  /// Columns and variances from P_, which is P.
  void take_vehicle();
  /// The columns into P_.
  void put_vehicle() const;
  /// Applies what waits.
  void pass() const;
  void pass(const double* W, Index panel_stride, Index columns) const;

  /// Room for what waits and one more correction that may.
  static constexpr Index kWaitingColumns = 2 * (kMostWaiting - 1),
                         kWaitingStride = kPanelRows * kWaitingColumns;

  Index vehicle_;
  const PanelKernel* kernel_;
  Matrix columns_;    ///< of the vehicle, whole_panels(n) rows
  Vector variances_;  ///< whole_panels(n)
  /// n×n, all of P or, without what waits, the lower triangle of the map.
  mutable Matrix P_;
  mutable bool is_whole_ = false;

  mutable AlignedVector waiting_;  ///< panels of W, zero in the rows of the vehicle and beyond n
  mutable Index waiting_columns_ = 0;
};

}  // namespace credence::internal
