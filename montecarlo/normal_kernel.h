#pragma once

#include <cstdint>

#include "montecarlo/cpu_dispatch.h"

/// @file
/// The compiled kernels behind NoiseSource, one for each instruction set. Internal: use montecarlo/noise.h.
/// Plain types only, since the files that include this are compiled for more than the portable machine.

namespace credence {

/// Philox words of one stream of normals, as montecarlo/noise.h lays them out, but for the slot.
struct NoiseBlockKey {
  std::uint64_t key;      ///< Philox key, low word first
  std::uint64_t run;      ///< counter words 0 and 3
  std::uint32_t word1;    ///< counter word 1
  std::uint32_t purpose;  ///< counter word 2 with slot 0
};

/// The functions of one instruction set.
struct NormalKernel {
  /// out[2 i], out[2 i + 1] = the block of slot first_slot + i: its words 0 and 1, its words 2 and 3, each
  /// pair as one number with the first word as its high half; 0 <= i < count.
  void (*bits)(const NoiseBlockKey&, std::uint32_t first_slot, std::uint64_t* out, std::int64_t count);
  /// out[i] = normal `half` (0 or 1) of the block of slot first_slot + i, 0 <= i < count.
  void (*slots)(const NoiseBlockKey&, unsigned half, std::uint32_t first_slot, double* out,
                std::int64_t count);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const NormalKernel& normal_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const NormalKernel* normal_kernel_scalar();
const NormalKernel* normal_kernel_avx2();
const NormalKernel* normal_kernel_avx512();

}  // namespace credence
