#include "montecarlo/lanes/intermittent_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence::internal {

const IntermittentKernel& intermittent_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(intermittent_kernel));
}

}  // namespace credence::internal
