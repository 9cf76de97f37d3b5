#include "core/simd/panel_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence::internal {

const PanelKernel& panel_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(panel_kernel));
}

}  // namespace credence::internal
