#include "core/panel_kernel.h"

#include <stdexcept>
#include <string>

namespace credence {

const PanelKernel& panel_kernel(InstructionSet set) {
  const PanelKernel* kernel = nullptr;
  if (is_supported(set)) {
    kernel = set == InstructionSet::avx512 ? panel_kernel_avx512()
             : set == InstructionSet::avx2 ? panel_kernel_avx2()
                                           : panel_kernel_scalar();
  }
  if (!kernel) {
    throw std::invalid_argument(std::string("this machine does not support the instruction set ") +
                                instruction_set_name(set));
  }
  return *kernel;
}

}  // namespace credence
