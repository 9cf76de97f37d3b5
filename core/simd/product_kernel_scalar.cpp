#include <cmath>

#include "core/simd/fused_multiply_add.h"
#include "core/simd/panel_kernel.h"
#include "core/simd/product_kernel.h"

namespace credence {
namespace {

#include "core/simd/panel_pack_scalar.inc"
//
#include "core/simd/product_kernel_body.inc"

}  // namespace

const ProductKernel* product_kernel_scalar() {
  static constexpr ProductKernel kernel{&multiply};
  return &kernel;
}

}  // namespace credence
