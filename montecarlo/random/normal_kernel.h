#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind NoiseSource, one for each instruction set. Internal: use
/// montecarlo/random/noise.h. Plain types only, since the files that include this are compiled for more than
/// the portable machine.

namespace credence::internal {

/// Runs that are simulated side by side, whatever the width of the machine's registers.
inline constexpr int kNoiseLanes = 32;

/// Philox words of one stream of normals, as montecarlo/random/noise.h lays them out, but for the slot.
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
  /// out[i] = normal `quarter` (0 … 3) of the block of slot first_slot + i, 0 <= i < count.
  void (*slots)(const NoiseBlockKey&, unsigned quarter, std::uint32_t first_slot, double* out,
                std::int64_t count);
  /// All four: out[quarter count + i].
  void (*steps)(const NoiseBlockKey&, std::uint32_t first_slot, double* out, std::int64_t count);
  /// Normals of the slots 0 … slots − 1 of kNoiseLanes runs:
  /// out[((slot groups + g) 4 + quarter) kNoiseLanes + lane] = normal of run `run` + lane, word 1 `word1` +
  /// g.
  void (*runs)(const NoiseBlockKey&, std::int64_t groups, std::int64_t slots, double* out);
  /// The blocks of one slot (word 2 is `purpose`) of kNoiseLanes runs, in the pairs of `bits`:
  /// out[(2 g + half) kNoiseLanes + lane] = run `run` + lane, word 1 `word1` + g, 0 <= g < groups.
  void (*run_bits)(const NoiseBlockKey&, std::int64_t groups, std::uint64_t* out);
  /// The pairs of normals of given bits: out[(2 h + i) kNoiseLanes + lane], i = 0, 1, of
  /// bits[h kNoiseLanes + lane], 0 <= h < halves.
  void (*pairs)(const std::uint64_t* bits, std::int64_t halves, double* out);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const NormalKernel& normal_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const NormalKernel* normal_kernel_scalar();
const NormalKernel* normal_kernel_avx2();
const NormalKernel* normal_kernel_avx512();

}  // namespace credence::internal
