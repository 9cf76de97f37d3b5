#include "montecarlo/random/normal_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

#include <cstdint>

namespace credence {
namespace {

#include "montecarlo/random/normal_kernel_pack_avx2.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"

}  // namespace

const NormalKernel* normal_kernel_avx2() {
  static constexpr NormalKernel kernel{&bits_of_slots,   &normals_of_slots, &normals_of_four_steps,
                                       &normals_of_runs, &bits_of_runs,     &normals_of_blocks};
  return &kernel;
}

}  // namespace credence

#else

namespace credence {

const NormalKernel* normal_kernel_avx2() { return nullptr; }

}  // namespace credence

#endif
