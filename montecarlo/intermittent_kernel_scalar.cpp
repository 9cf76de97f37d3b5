#include <bit>
#include <cmath>
#include <cstdint>

#include "montecarlo/intermittent_kernel.h"

namespace credence {
namespace {

#include "montecarlo/normal_kernel_pack_scalar.inc"
//
#include "montecarlo/intermittent_kernel_body.inc"

}  // namespace

const IntermittentKernel* intermittent_kernel_scalar() { return &kIntermittentKernel; }

}  // namespace credence
