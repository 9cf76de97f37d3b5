#include "core/simd/trigonometry_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
//
#include "core/simd/trigonometry_body.inc"

std::size_t arc_tangents_of_packs(const double* y, const double* x, double* out, std::size_t count) {
  std::size_t i = 0;
  for (; i + LanePack::kLanes <= count; i += LanePack::kLanes) {
    const LanePack::D a = LanePack::load(y + i), b = LanePack::load(x + i);
    if (!has_plain_sides<LanePack>(a, b)) break;
    LanePack::store(out + i, arc_tangent_lanes<LanePack>(a, b));
  }
  return i;
}

constexpr TrigonometryKernel kTrigonometryKernel{&arc_tangents_of_packs, LanePack::kLanes};

}  // namespace

const TrigonometryKernel* CREDENCE_OF_SET(trigonometry_kernel)() { return &kTrigonometryKernel; }

}  // namespace credence::internal
