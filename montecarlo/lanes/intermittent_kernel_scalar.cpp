#include <bit>
#include <cmath>
#include <cstdint>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/lanes/intermittent_kernel.h"

namespace credence {
namespace {

#include "core/simd/lane_pack_scalar.inc"
using Pack = LanePack;
//
#include "montecarlo/lanes/intermittent_kernel_body.inc"

}  // namespace

const IntermittentKernel* intermittent_kernel_scalar() { return &kIntermittentKernel; }

}  // namespace credence
