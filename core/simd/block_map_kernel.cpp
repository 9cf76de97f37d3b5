#include "core/simd/block_map_kernel.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/simd/kernel_choice.h"

namespace credence::internal {

const BlockMapKernel* block_map_kernel(InstructionSet set, int vehicle, int landmark) {
  return find_kernel(set, CREDENCE_KERNELS(block_map_kernel), vehicle, landmark);
}

const BlockMapKernel& block_map_kernel(int vehicle, int landmark) {
  if (const BlockMapKernel* kernel = block_map_kernel(best_instruction_set(), vehicle, landmark))
    return *kernel;
  throw std::invalid_argument(
      fmt::format("no map kernel for a vehicle of {} and landmarks of {}", vehicle, landmark));
}

}  // namespace credence::internal
