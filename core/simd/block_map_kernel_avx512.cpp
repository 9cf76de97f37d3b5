#include "core/simd/block_map_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512DQ__) && defined(__AVX512VL__)

#include "core/simd/avx512_intrinsics.h"

#include <cstdint>

namespace credence {
namespace {

#include "core/simd/lane_pack_avx512.inc"
using Pack = LanePack;
//
#include "core/simd/block_map_kernel_body.inc"

}  // namespace

const BlockMapKernel* block_map_kernel_avx512(int vehicle, int landmark) {
  return passes_for(vehicle, landmark);
}

}  // namespace credence

#else

namespace credence {

const BlockMapKernel* block_map_kernel_avx512(int, int) { return nullptr; }

}  // namespace credence

#endif
