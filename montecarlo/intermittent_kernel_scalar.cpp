#include <bit>
#include <cmath>
#include <cstdint>

#include "montecarlo/intermittent_kernel.h"

namespace credence {
namespace {

#include "core/lane_pack_scalar.inc"
using Pack = LanePack;
//
#include "montecarlo/intermittent_kernel_body.inc"

}  // namespace

const IntermittentKernel* intermittent_kernel_scalar() { return &kIntermittentKernel; }

}  // namespace credence
