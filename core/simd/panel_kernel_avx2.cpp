#include "core/simd/panel_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

namespace credence {
namespace {

#include "core/simd/panel_pack_avx2.inc"
//
#include "core/simd/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_avx2() { return &kPanelKernel; }

}  // namespace credence

#else

namespace credence {

const PanelKernel* panel_kernel_avx2() { return nullptr; }

}  // namespace credence

#endif
