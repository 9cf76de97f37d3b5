#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind PlanarLanes, one for each instruction set. Internal: use
/// montecarlo/lanes/planar_lanes.h. Plain types only, since the files that include this are compiled for more
/// than the portable machine.
///
/// Every number is kPlanarLanes doubles, one of each run, aligned to 64 bytes; matrices of them are stored by
/// columns. What happens in one lane does not depend on the others.

namespace credence::internal {

/// Runs that are filtered side by side, whatever the width of the machine's registers.
inline constexpr int kPlanarLanes = 8;

/// What the kernels work on.
struct PlanarLanesData {
  std::int64_t states;  ///< n, the map complete
  std::int64_t padded;  ///< n rounded up to a multiple of 4, the size of x and P
  double* x;            ///< `padded`
  double* P;            ///< `padded`², the lower triangle; rows of what is not known yet are zero

  std::int64_t measured;       ///< M, landmarks and anchors in this update
  const std::int64_t* offset;  ///< M: where they start in the state, −1 for an anchor
  const double* const* place;  ///< M: the two coordinates of each
  double* difference;          ///< 3·M: landmark − position, and its length
  double* H;         ///< 10·M: H_r (2×3) and H_l (2×2) by rows; all zero in a lane that sees nothing
  const double* R;   ///< 2·M: measurement variances
  const double* nu;  ///< 2·M: innovations
  double* innovation_covariance;  ///< 3·M: S_00, S_11 and S_10 of each
  /// (2M + padded + 1) × 2M: S, P Hᵀ and νᵀ, which become L with the inverse of its diagonal, W = P Hᵀ L⁻ᵀ
  /// and (L⁻¹ ν)ᵀ, where S = L Lᵀ.
  double* A;
  double* nis;    ///< 1
  double* check;  ///< 1: zero where a Cholesky factor exists, else not a number

  double* columns;  ///< 8·M, to work in
  double* share;    ///< 1: tr(S⁻¹ R)
  double* doubt;    ///< 1: the largest S_ii/L_ii²
};

/// The NEES of all lanes, from a P that is left alone.
struct PlanarLanesNees {
  std::int64_t padded;
  const double* P;
  const double* diagonal;  ///< `padded`: that of P, with ones for the states that are left out
  const double* error;     ///< `padded`: zeros for these
  std::int64_t below;      ///< rows of L under the triangle: 1, or 4 for `normalise`
  double* L;               ///< (padded + below) × padded: L with the inverse of its diagonal, (L⁻¹ e)ᵀ
  double* nees;
  double* vehicle_nees;  ///< of the first three states
  double* check;         ///< as above
  double* map_nees;      ///< of the other states
  double* doubt;         ///< the largest P_ii/L_ii²
};

/// The functions of one instruction set.
struct PlanarLanesKernel {
  /// P_rr ← F P_rr Fᵀ + Q, P_rf ← F P_rf; F 3×3 by rows, Q = G Q_u Gᵀ as (0,0) (1,0) (1,1) (2,0) (2,1) (2,2).
  void (*predict)(const PlanarLanesData&, const double* F, const double* Q);
  /// Makes the map block diagonal by the pairwise sum of core/inflation/pairwise_bound.h.
  void (*decorrelate)(const PlanarLanesData&);
  /// `difference` and H of range and bearing at the estimate.
  void (*linearise)(const PlanarLanesData&);
  /// A, `nis` and `check`.
  void (*innovate)(const PlanarLanesData&);
  /// x += K ν and P ← P − W Wᵀ.
  void (*correct)(const PlanarLanesData&);
  /// `share` and `doubt`, of the factor in A.
  void (*share_noise)(const PlanarLanesData&);
  /// L, `nees`, `vehicle_nees`, `check` and `doubt`.
  void (*nees)(const PlanarLanesNees&);
  /// The rest, of an L with the four rows below.
  void (*normalise)(const PlanarLanesNees&);
  /// Of each landmark by its own block, (n − 3)/2; not a number where it is not known.
  void (*landmark_nees)(const PlanarLanesData&, const double* error, double* nees);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const PlanarLanesKernel& planar_lanes_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const PlanarLanesKernel* planar_lanes_kernel_scalar();
const PlanarLanesKernel* planar_lanes_kernel_avx2();
const PlanarLanesKernel* planar_lanes_kernel_avx512();

}  // namespace credence::internal
