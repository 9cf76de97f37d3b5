#include <bit>
#include <cmath>
#include <cstdint>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/lanes/planar_lanes_kernel.h"

namespace credence {
namespace {

#include "core/simd/lane_pack_scalar.inc"
using Pack = LanePack;
//
#include "montecarlo/lanes/planar_lanes_kernel_body.inc"

}  // namespace

const PlanarLanesKernel* planar_lanes_kernel_scalar() { return &kPlanarLanesKernel; }

}  // namespace credence
