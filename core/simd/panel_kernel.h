#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind PanelCovariance, one for each instruction set. Internal: use
/// core/filters/panel_covariance.h. Plain types only, since the files that include this are compiled for more
/// than the portable machine.
///
/// Rows of the map come in panels of eight. A "panel array" of k columns holds element (8 p + i, j) at
/// p stride + 8 j + i. The lower triangle of the symmetric map covariance is packed panel by panel, panel p
/// as its p + 1 blocks of 8×8, row-major, up to and including the diagonal one, which is stored whole.
///
/// Arithmetic, the same at every width: every sum takes its terms one by one, in the order in which this
/// header writes them, by fused multiply-adds.

namespace credence {

inline constexpr std::int64_t kPanelRows = 8;

/// Where panel `p` of a packed triangle starts, in doubles.
constexpr std::int64_t panel_offset(std::int64_t p) { return kPanelRows * kPanelRows * p * (p + 1) / 2; }

/// Where element (row, column) lies in a packed triangle; column / 8 <= row / 8.
constexpr std::int64_t packed_index(std::int64_t row, std::int64_t column) {
  return panel_offset(row / kPanelRows) + kPanelRows * kPanelRows * (column / kPanelRows) +
         kPanelRows * (row % kPanelRows) + column % kPanelRows;
}

/// One observation of a batch: its measurements share a landmark.
struct PanelObservation {
  std::int64_t column;  ///< where the landmark starts in the map, −1 for one that is no state
  const double* H_r;    ///< measurements × vehicle, row-major
  const double* H_l;    ///< measurements × landmark, row-major
};

/// Dimensions and storage of a PanelCovariance: P_ff = P − W Wᵀ with the pending columns of W.
struct PanelStorage {
  std::int64_t panels;     ///< of eight map rows
  std::int64_t vehicle;    ///< n_r
  std::int64_t landmark;   ///< d
  const double* P;         ///< packed lower triangle
  const double* rows;      ///< P_fr, a panel array with stride 8 vehicle
  const double* diagonal;  ///< of P_ff, pending columns taken off
  double* W;               ///< a panel array; kernels write the columns after the pending ones
  std::int64_t stride;     ///< of W
  std::int64_t pending;    ///< columns
};

/// What a correction by the columns of one batch, Y = P_f Hᵀ, needs and gives.
struct PanelCorrection {
  std::int64_t columns;    ///< dim ν
  const double* L;         ///< Cholesky factor of S, columns × columns, column-major
  const double* inverse;   ///< 1 / L_kk
  const double* whitened;  ///< L⁻¹ ν
  const double* F;         ///< vehicle × vehicle, row-major: P_fr is taken as P_fr Fᵀ
  const double* W_r;       ///< the vehicle's rows of Y L⁻ᵀ, vehicle × columns, row-major
  double* rows;            ///< new P_fr
  double* diagonal;        ///< new diagonal
  double* state_change;    ///< of the map
};

/// The functions of one instruction set.
struct PanelKernel {
  /// Column pending + q o + i of W = P_fr H_r(i)ᵀ + Σ_a H_l(i, a) (P_ff)(:, column + a) for measurement i < q
  /// of observation o, the pending columns of W taken off P_ff in their order.
  void (*observe)(const PanelStorage&, const PanelObservation*, std::int64_t count,
                  std::int64_t measurements);
  /// W = Y L⁻ᵀ in place; rows = P_fr Fᵀ − W W_rᵀ, diagonal −= W², state_change = W whitened. False if an
  /// element of the new diagonal is negative or no number.
  bool (*correct)(const PanelStorage&, const PanelCorrection&);
  /// P −= W Wᵀ for `columns` columns of the panel array W, one pass over the packed triangle.
  void (*downdate)(double* P, std::int64_t panels, const double* W, std::int64_t stride,
                   std::int64_t columns);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const PanelKernel& panel_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const PanelKernel* panel_kernel_scalar();
const PanelKernel* panel_kernel_avx2();
const PanelKernel* panel_kernel_avx512();

}  // namespace credence
