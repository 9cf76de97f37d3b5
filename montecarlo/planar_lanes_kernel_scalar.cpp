#include <bit>
#include <cmath>
#include <cstdint>

#include "montecarlo/planar_lanes_kernel.h"

namespace credence {
namespace {

#include "montecarlo/normal_kernel_pack_scalar.inc"
//
#include "montecarlo/planar_lanes_kernel_body.inc"

}  // namespace

const PlanarLanesKernel* planar_lanes_kernel_scalar() { return &kPlanarLanesKernel; }

}  // namespace credence
