#include <bit>
#include <cmath>
#include <cstdint>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/random/normal_kernel.h"

namespace credence {
namespace {

#include "montecarlo/random/normal_kernel_pack_scalar.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"

}  // namespace

const NormalKernel* normal_kernel_scalar() {
  static constexpr NormalKernel kernel{&bits_of_slots,   &normals_of_slots, &normals_of_four_steps,
                                       &normals_of_runs, &bits_of_runs,     &normals_of_blocks};
  return &kernel;
}

}  // namespace credence
