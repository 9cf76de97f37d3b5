#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/lanes/linear_kernel_plan.h"
#include "montecarlo/random/normal_kernel.h"

namespace credence {
namespace {

#include "montecarlo/random/normal_kernel_pack_scalar.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"
//
#include "montecarlo/lanes/linear_kernel_body.inc"

}  // namespace

const LinearKernel* linear_kernel_scalar() {
  static constexpr LinearKernel kernel{&simulate_runs};
  return &kernel;
}

}  // namespace credence
