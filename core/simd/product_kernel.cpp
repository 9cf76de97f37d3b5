#include "core/simd/product_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence {

const ProductKernel& product_kernel(InstructionSet set) {
  return require_kernel(set, product_kernel_scalar, product_kernel_avx2, product_kernel_avx512);
}

}  // namespace credence
