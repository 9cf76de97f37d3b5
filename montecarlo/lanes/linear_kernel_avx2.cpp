#include "montecarlo/lanes/linear_kernel_plan.h"
#include "montecarlo/random/normal_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace credence {
namespace {

#include "montecarlo/random/normal_kernel_pack_avx2.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"
//
#include "montecarlo/lanes/linear_kernel_body.inc"

}  // namespace

const LinearKernel* linear_kernel_avx2() {
  static constexpr LinearKernel kernel{&simulate_runs};
  return &kernel;
}

}  // namespace credence

#else

namespace credence {

const LinearKernel* linear_kernel_avx2() { return nullptr; }

}  // namespace credence

#endif
