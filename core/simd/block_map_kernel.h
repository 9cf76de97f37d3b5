#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The passes of BlockMapEkfSlam over a large map, eight landmarks at a time. Internal.
///
/// Every pass gives the same bits on every instruction set: products are fused where written so, and sums
/// have eight parts, that of landmark j being j mod 8, which are joined in this order.

namespace credence::internal {

inline constexpr std::int64_t kMapPack = 8;  ///< landmarks of a pack
inline constexpr int kMaxDirections = 2;     ///< scalar measurements of one pass
inline constexpr int kMaxKernelVehicle = 3;  ///< n_r

/// A map as arrays over its landmarks, padded with zeros to whole packs.
struct BlockMapArrays {
  double* rf = nullptr;      ///< X: n_r·d arrays; number a·d + c belongs to vehicle row a, component c
  double* blocks = nullptr;  ///< D: d(d+1)/2 arrays: xx, xy, yy
  std::int64_t stride = 0;   ///< doubles from one array to the next
  std::int64_t packs = 0;
};

/// Directions g (n_r each): l_j = X_jᵀ g is what one scalar measurement has to do with landmark j, but for
/// its scale.
struct BlockMapDirections {
  double g[kMaxDirections][kMaxKernelVehicle] = {};
  int count = 0;
};

/// As many directions as the vehicle has states, for a batch of measurements: C_j = X_jᵀ [g_0 g_1 …].
struct BlockMapFrame {
  double g[kMaxKernelVehicle][kMaxKernelVehicle] = {};
};

/// Sums over a map of C_j, σ_j = ‖C_j‖.
struct BlockMapMoments {
  double norms = 0.0;  ///< Σ σ_j
  /// Σ C_jᵀ C_j / σ_j, the lower triangle by rows.
  double squares[kMaxKernelVehicle * (kMaxKernelVehicle + 1) / 2] = {};
};

/// The norms σ_j = ‖l_j‖ of one direction over a map: the largest, and the sum of all others.
struct BlockMapNorms {
  double largest = 0.0;
  double others = 0.0;
};

/// One instruction set's passes for one n_r and d.
struct BlockMapKernel {
  /// out[i] of each direction; reciprocals[i·stride + j] = 1/σ_j. σ_j below 1e-150 counts as about that.
  void (*norms)(const BlockMapArrays& map, const BlockMapDirections& directions, double* reciprocals,
                BlockMapNorms* out);
  /// D_j += Σ_i excess_i/σ_ij · l_ij l_ijᵀ, the reciprocals being those of `norms`; directions with an excess
  /// of 0 are left out. Returns Σ_j tr D_j.
  double (*inflate)(const BlockMapArrays& map, const BlockMapDirections& directions, const double* excess,
                    const double* reciprocals);
  /// Of all directions of a frame together; reciprocals[j] = 1/σ_j, σ_j below 1e-150 counting as about that.
  void (*moments)(const BlockMapArrays& map, const BlockMapFrame& frame, double* reciprocals,
                  BlockMapMoments* out);
  /// D_j += C_j C_jᵀ / σ_j, the reciprocals being those of `moments` for another frame. Returns Σ_j tr D_j.
  double (*spread)(const BlockMapArrays& map, const BlockMapFrame& frame, const double* reciprocals);
  /// shift_j (array c of n_landmarks: c·stride) = X_jᵀ w, then X_j ← T X_j, T being n_r×n_r by rows.
  void (*transform)(const BlockMapArrays& map, const double* T, const double* w, double* shift);
};

/// The passes for this instruction set; nullptr if there are none for it in this binary or for this n_r, d.
/// There are some for n_r of 1 and 3, and d of 1 and 2.
const BlockMapKernel* block_map_kernel(InstructionSet set, int vehicle, int landmark);

/// Those of the widest supported set. Throws std::invalid_argument where there are none for n_r and d.
const BlockMapKernel& block_map_kernel(int vehicle, int landmark);

const BlockMapKernel* block_map_kernel_scalar(int vehicle, int landmark);
const BlockMapKernel* block_map_kernel_avx2(int vehicle, int landmark);
const BlockMapKernel* block_map_kernel_avx512(int vehicle, int landmark);

}  // namespace credence::internal
