#include "montecarlo/random/normal_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "montecarlo/random/normal_kernel_pack.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"

}  // namespace

const NormalKernel* CREDENCE_OF_SET(normal_kernel)() {
  static constexpr NormalKernel kernel{&bits_of_slots,   &normals_of_slots, &normals_of_four_steps,
                                       &normals_of_runs, &bits_of_runs,     &normals_of_blocks};
  return &kernel;
}

}  // namespace credence::internal
