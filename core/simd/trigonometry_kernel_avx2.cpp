#include "core/simd/trigonometry_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace credence {
namespace {

#include "core/simd/lane_pack_avx2.inc"
//
#include "core/simd/trigonometry_kernel_body.inc"

}  // namespace

const TrigonometryKernel* trigonometry_kernel_avx2() { return &kTrigonometryKernel; }

}  // namespace credence

#else

namespace credence {

const TrigonometryKernel* trigonometry_kernel_avx2() { return nullptr; }

}  // namespace credence

#endif
