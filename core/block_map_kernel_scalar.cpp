#include <bit>
#include <cmath>
#include <cstdint>

#include "core/block_map_kernel.h"

namespace credence {
namespace {

#include "core/block_map_kernel_pack_scalar.inc"
//
#include "core/block_map_kernel_body.inc"

}  // namespace

const BlockMapKernel* block_map_kernel_scalar(int vehicle, int landmark) {
  return passes_for(vehicle, landmark);
}

}  // namespace credence
