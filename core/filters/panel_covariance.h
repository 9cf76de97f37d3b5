#pragma once

#include <vector>

#include "core/filters/observation_batch.h"
#include "core/simd/aligned_vector.h"
#include "core/simd/cpu_dispatch.h"
#include "core/simd/panel_kernel.h"
#include "core/types.h"

namespace credence {

/// The covariance of a SLAM state, kept for one pass over one triangle of P_ff per update, or per several.
///
/// P = [P_rr P_rf; P_fr P_ff] with the vehicle's rows apart, so that a prediction touches nothing else, and
/// P_ff = P_0 − W Wᵀ: a correction appends columns to W, and a flush takes them off the packed lower triangle
/// of P_0 all at once. Every element of P_ff is the same sequence of fused multiply-adds whenever that
/// happens, so neither the number of pending columns nor the instruction set changes a bit of what is read.
/// P is symmetric by construction. Once the map has its size, nothing here allocates but what says so.
class PanelCovariance {
 public:
  /// P is vehicle × vehicle and zero. Throws std::invalid_argument for sizes < 1, flush_steps < 1, or an
  /// instruction set that this machine does not support.
  PanelCovariance(Index vehicle, Index landmark, int flush_steps,
                  InstructionSet set = best_instruction_set());

  /// P ← the lower triangle of a matrix of any size vehicle + k landmark, k >= 0.
  void reset(MatrixRef P);

  /// P ← the lower triangle of a matrix of the same size; whitened_columns() remains.
  void replace(MatrixRef P);

  Index size() const { return vehicle_ + map_size_; }  ///< n
  Index map_size() const { return map_size_; }         ///< n_f
  double trace() const;

  /// P_rr ← F P_rr Fᵀ + Q_r, P_rf ← F P_rf; the latter is carried out with the next correction: O(1).
  void predict(MatrixRef F, MatrixRef Q_r);

  /// Computes Y = P Hᵀ and `HPHt` = H P Hᵀ: O(n (rows of H) (1 + pending columns)). Throws
  /// std::invalid_argument for a landmark that is not in the map, or sizes that do not match.
  void project(const ObservationBatch& batch, Eigen::Ref<Matrix> HPHt);

  /// Makes W = Y L⁻ᵀ of the Y just projected, with L the lower triangle of `L`, L Lᵀ = S, and prepares the
  /// correction P − W Wᵀ. False if a variance would become negative or no number. Changes nothing of P.
  bool whiten(MatrixRef L, VectorRef whitened_innovation);

  /// Carries out the correction that whiten() prepared.
  void commit();

  /// x += W (L⁻¹ ν) of the last whiten(); x is n.
  void add_state_change(Vector& x) const;

  /// W of the last whiten(), n × rows of H, n that of then; allocates.
  Matrix whitened_columns() const;

  /// Appends a landmark with P_lx = J_r P_rx and P_ll = `own`: O(n).
  void append(MatrixRef J_r, MatrixRef own);

  /// Takes the pending columns off the triangle; nothing that can be read changes.
  void flush();
  Index pending_columns() const { return pending_; }

  double operator()(Index row, Index column) const;  ///< O(pending columns)
  /// A block of P, of any size and at any time; allocates. Throws std::invalid_argument beyond P.
  Matrix block(Index row, Index column, Index rows, Index columns) const;
  Matrix dense() const;  ///< the whole of P: O(n² pending columns); allocates

 private:
  double vehicle_map(Index r, Index column) const;
  double map_element(Index row, Index column) const;
  PanelStorage storage();
  /// Of W. Odd multiples of a line: panels do not fall on the same lines of a cache.
  Index stride() const { return kPanelRows * (capacity_ | 1); }
  /// Where element (row, k) of W lies.
  std::size_t column_index(Index row, Index k) const {
    return static_cast<std::size_t>(row / kPanelRows * stride() + kPanelRows * k + row % kPanelRows);
  }
  void make_room(Index columns);
  void resize_map(Index map_size);
  void settle_motion();
  void project_vehicle(const ObservationBatch& batch);
  void innovation_covariance(const ObservationBatch& batch, Eigen::Ref<Matrix> HPHt) const;
  bool whiten_vehicle(MatrixRef L, VectorRef whitened_innovation);

  const PanelKernel* kernel_;
  Index vehicle_, landmark_, flush_steps_;
  Index map_size_ = 0, panels_ = 0;
  Matrix P_rr_, F_;  ///< F_: motion that the rows of the vehicle have not seen yet
  Matrix scratch_;   ///< of the size of P_rr
  bool moved_ = false;
  AlignedVector triangle_, rows_, diagonal_, W_;
  Index pending_ = 0, steps_ = 0;
  Index capacity_ = 0;  ///< columns of W

  // Of the last batch
  std::vector<PanelObservation> observations_;
  std::vector<double> H_r_, PHt_r_, W_r_, F_row_major_, inverse_;  ///< row-major
  Vector change_r_;
  AlignedVector new_rows_, new_diagonal_, change_;
  Index first_column_ = 0, columns_ = 0, rows_of_columns_ = 0;
};

}  // namespace credence
