#include "montecarlo/random/normal_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence::internal {

const NormalKernel& normal_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(normal_kernel));
}

}  // namespace credence::internal
