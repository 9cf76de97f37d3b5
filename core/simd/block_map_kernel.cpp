#include "core/simd/block_map_kernel.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/simd/kernel_choice.h"

namespace credence {

const BlockMapKernel* block_map_kernel(InstructionSet set, int vehicle, int landmark) {
  return find_kernel(set, block_map_kernel_scalar, block_map_kernel_avx2, block_map_kernel_avx512, vehicle,
                     landmark);
}

const BlockMapKernel& block_map_kernel(int vehicle, int landmark) {
  if (const BlockMapKernel* kernel = block_map_kernel(best_instruction_set(), vehicle, landmark))
    return *kernel;
  throw std::invalid_argument(
      fmt::format("no map kernel for a vehicle of {} and landmarks of {}", vehicle, landmark));
}

}  // namespace credence
