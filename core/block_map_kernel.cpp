#include "core/block_map_kernel.h"

#include <fmt/format.h>

#include <stdexcept>

namespace credence {

const BlockMapKernel* block_map_kernel(InstructionSet set, int vehicle, int landmark) {
  if (!is_supported(set)) return nullptr;
  switch (set) {
    case InstructionSet::scalar:
      return block_map_kernel_scalar(vehicle, landmark);
    case InstructionSet::avx2:
      return block_map_kernel_avx2(vehicle, landmark);
    case InstructionSet::avx512:
      return block_map_kernel_avx512(vehicle, landmark);
  }
  return nullptr;
}

const BlockMapKernel& block_map_kernel(int vehicle, int landmark) {
  for (const InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2, InstructionSet::scalar}) {
    if (const BlockMapKernel* kernel = block_map_kernel(set, vehicle, landmark)) return *kernel;
  }
  throw std::invalid_argument(
      fmt::format("no map kernel for a vehicle of {} and landmarks of {}", vehicle, landmark));
}

}  // namespace credence
