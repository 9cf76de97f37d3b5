#include "montecarlo/lanes/intermittent_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence {

const IntermittentKernel& intermittent_kernel(InstructionSet set) {
  return require_kernel(set, intermittent_kernel_scalar, intermittent_kernel_avx2,
                        intermittent_kernel_avx512);
}

}  // namespace credence
