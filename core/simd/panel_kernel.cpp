#include "core/simd/panel_kernel.h"

#include "core/simd/kernel_choice.h"

namespace credence {

const PanelKernel& panel_kernel(InstructionSet set) {
  return require_kernel(set, panel_kernel_scalar, panel_kernel_avx2, panel_kernel_avx512);
}

}  // namespace credence
