#include "core/simd/trigonometry_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
//
#include "core/simd/trigonometry_body.inc"

/// One pack; false if a side takes the long way.
bool arc_tangents_of_pack(const double* y, const double* x, double* out) {
  const LanePack::D a = LanePack::load(y), b = LanePack::load(x);
  if (!has_plain_sides<LanePack>(a, b)) return false;
  LanePack::store(out, arc_tangent_lanes<LanePack>(a, b));
  return true;
}

std::size_t arc_tangents_of_packs(const double* y, const double* x, double* out, std::size_t count) {
  constexpr std::size_t kLanes = LanePack::kLanes;
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    if (!arc_tangents_of_pack(y + i, x + i, out + i)) return i;
  }
  const std::size_t rest = count - i;
  if (rest == 0) return i;
  // The last pack is filled up with ones.
  alignas(64) double rest_y[kLanes], rest_x[kLanes], rest_out[kLanes];
  for (std::size_t j = 0; j < kLanes; ++j) {
    rest_y[j] = j < rest ? y[i + j] : 1.0;
    rest_x[j] = j < rest ? x[i + j] : 1.0;
  }
  if (!arc_tangents_of_pack(rest_y, rest_x, rest_out)) return i;
  for (std::size_t j = 0; j < rest; ++j) out[i + j] = rest_out[j];
  return count;
}

constexpr TrigonometryKernel kTrigonometryKernel{&arc_tangents_of_packs, LanePack::kLanes};

}  // namespace

const TrigonometryKernel* CREDENCE_OF_SET(trigonometry_kernel)() { return &kTrigonometryKernel; }

}  // namespace credence::internal
