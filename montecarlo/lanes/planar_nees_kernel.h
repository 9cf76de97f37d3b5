#pragma once

#include "montecarlo/lanes/planar_lanes_kernel.h"

/// @file
/// The compiled kernels behind PlanarNeesLanes, in the form of those of planar_lanes_kernel.h.

namespace credence::internal {

/// What they keep from step to step (core/filters/nees_along_run.h tells what it is), and what they take.
struct PlanarNeesData {
  std::int64_t states;  ///< n, the map complete
  double* Sigma;        ///< 6: (0,0) (1,0) (1,1) (2,0) (2,1) (2,2)
  double* A;            ///< 3·n: three numbers of every state, those of the vehicle not used
  double* w;            ///< n, likewise

  const double* error;  ///< n: of the map before the step, or of the whole state after it
  const double* prior;  ///< 3: of the predicted pose
  double* tells;        ///< 2·M: H e + ν, to work in
  double* scalars;  ///< 2·M: s, the variances of the scalars given what the map and those before them tell

  double* nees;
  double* map_nees;
  double* inverse_root;  ///< 1/√det Σ
  double* doubt;         ///< the largest P_ii/L_ii² of the pose, Σ = L Lᵀ; not a number without a factor
  double* trace;         ///< tr P
  double* dof;           ///< how many variances are not zero
  double* map_error;     ///< e_fᵀ e_f
  double* largest;       ///< |e_i|
  double* finite;        ///< 0, or not a number where an error is none or infinite

  double* vehicle_nees;   ///< of the pose by its own block of P
  double* vehicle_white;  ///< 3: L⁻¹ e of that
};

/// The functions of one instruction set.
struct PlanarNeesKernel {
  /// Σ ← F Σ Fᵀ + Q, A ← A Fᵀ, as PlanarLanesKernel::predict.
  void (*move)(const PlanarNeesData&, const double* F, const double* Q);
  /// Starts anew from a P whose map is block diagonal; `determinants`, n/2, are those of its blocks, one
  /// where there is none.
  void (*start)(const PlanarNeesData&, const PlanarLanesData&, double* determinants);
  /// What the last update measured.
  void (*correct)(const PlanarNeesData&, const PlanarLanesData&);
  /// The values of the state's `error`.
  void (*judge)(const PlanarNeesData&, const PlanarLanesData&);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const PlanarNeesKernel& planar_nees_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const PlanarNeesKernel* planar_nees_kernel_scalar();
const PlanarNeesKernel* planar_nees_kernel_avx2();
const PlanarNeesKernel* planar_nees_kernel_avx512();

}  // namespace credence::internal
