#include <cmath>

#include "core/panel_kernel.h"
#include "core/product_kernel.h"

namespace credence {
namespace {

#include "core/panel_pack_scalar.inc"
//
#include "core/product_kernel_body.inc"

}  // namespace

const ProductKernel* product_kernel_scalar() {
  static constexpr ProductKernel kernel{&multiply};
  return &kernel;
}

}  // namespace credence
