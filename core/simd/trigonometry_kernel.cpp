#include "core/simd/trigonometry_kernel.h"

#include <algorithm>
#include <cstddef>

#include "core/manifold/trigonometry.h"
#include "core/simd/kernel_choice.h"

namespace credence::internal {
namespace {

/// What the kernel leaves is done one by one.
template <typename Packs, typename One>
void in_packs(std::size_t count, std::size_t lanes, Packs packs, One one) {
  for (std::size_t i = 0; i < count;) {
    i += packs(i);
    for (const std::size_t end = std::min(count, i + lanes); i < end; ++i) one(i);
  }
}

}  // namespace

const TrigonometryKernel& trigonometry_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(trigonometry_kernel));
}

void arc_tangents_by(const TrigonometryKernel& kernel, const double* y, const double* x, double* out,
                     std::size_t count) {
  in_packs(
      count, kernel.lanes,
      [&](std::size_t i) { return kernel.arc_tangents(y + i, x + i, out + i, count - i); },
      [&](std::size_t i) { out[i] = arc_tangent(y[i], x[i]); });
}

void sine_cosines_by(const TrigonometryKernel& kernel, const double* angles_rad, double* sines,
                     double* cosines, std::size_t count) {
  in_packs(
      count, kernel.lanes,
      [&](std::size_t i) { return kernel.sine_cosines(angles_rad + i, sines + i, cosines + i, count - i); },
      [&](std::size_t i) {
        const SineCosine both = sine_cosine(angles_rad[i]);
        sines[i] = both.sine;
        cosines[i] = both.cosine;
      });
}

void arc_tangents(const double* y, const double* x, double* out, std::size_t count) {
  static const TrigonometryKernel& kernel = trigonometry_kernel(best_instruction_set());
  arc_tangents_by(kernel, y, x, out, count);
}

void sine_cosines(const double* angles_rad, double* sines, double* cosines, std::size_t count) {
  static const TrigonometryKernel& kernel = trigonometry_kernel(best_instruction_set());
  sine_cosines_by(kernel, angles_rad, sines, cosines, count);
}

}  // namespace credence::internal
