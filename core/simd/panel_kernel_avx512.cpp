#include "core/simd/panel_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512DQ__) && defined(__AVX512VL__)

#include "core/simd/avx512_intrinsics.h"

namespace credence {
namespace {

#include "core/simd/panel_pack_avx512.inc"
//
#include "core/simd/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_avx512() { return &kPanelKernel; }

}  // namespace credence

#else

namespace credence {

const PanelKernel* panel_kernel_avx512() { return nullptr; }

}  // namespace credence

#endif
