#include <cmath>

#include "core/simd/fused_multiply_add.h"
#include "core/simd/panel_kernel.h"

namespace credence {
namespace {

#include "core/simd/panel_pack_scalar.inc"
//
#include "core/simd/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_scalar() { return &kPanelKernel; }

}  // namespace credence
