#include "core/simd/product_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence::internal {

const ProductKernel& product_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(product_kernel));
}

}  // namespace credence::internal
