#include "montecarlo/normal_kernel.h"

#include <stdexcept>
#include <string>

namespace credence {

const NormalKernel& normal_kernel(InstructionSet set) {
  const NormalKernel* kernel = nullptr;
  if (is_supported(set)) {
    kernel = set == InstructionSet::avx512 ? normal_kernel_avx512()
             : set == InstructionSet::avx2 ? normal_kernel_avx2()
                                           : normal_kernel_scalar();
  }
  if (!kernel) {
    throw std::invalid_argument(std::string("this machine does not support the instruction set ") +
                                instruction_set_name(set));
  }
  return *kernel;
}

}  // namespace credence
