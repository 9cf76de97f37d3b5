#include "montecarlo/random/normal_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence {

const NormalKernel& normal_kernel(InstructionSet set) {
  return require_kernel(set, normal_kernel_scalar, normal_kernel_avx2, normal_kernel_avx512);
}

}  // namespace credence
