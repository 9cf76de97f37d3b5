#include <bit>
#include <cmath>
#include <cstdint>

#include "core/simd/block_map_kernel.h"
#include "core/simd/fused_multiply_add.h"

namespace credence {
namespace {

#include "core/simd/lane_pack_scalar.inc"
using Pack = LanePack;
//
#include "core/simd/block_map_kernel_body.inc"

}  // namespace

const BlockMapKernel* block_map_kernel_scalar(int vehicle, int landmark) {
  return passes_for(vehicle, landmark);
}

}  // namespace credence
