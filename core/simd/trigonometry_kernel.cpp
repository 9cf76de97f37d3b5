#include "core/simd/trigonometry_kernel.h"

#include <algorithm>
#include <cstddef>

#include "core/manifold/trigonometry.h"
#include "core/simd/kernel_choice.h"

namespace credence::internal {
const TrigonometryKernel& trigonometry_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(trigonometry_kernel));
}

void arc_tangents_by(const TrigonometryKernel& kernel, const double* y, const double* x, double* out,
                     std::size_t count) {
  for (std::size_t i = 0; i < count;) {
    i += kernel.arc_tangents(y + i, x + i, out + i, count - i);
    // What the kernel leaves is done one by one.
    for (const std::size_t end = std::min(count, i + kernel.lanes); i < end; ++i)
      out[i] = arc_tangent(y[i], x[i]);
  }
}

void arc_tangents(const double* y, const double* x, double* out, std::size_t count) {
  static const TrigonometryKernel& kernel = trigonometry_kernel(best_instruction_set());
  arc_tangents_by(kernel, y, x, out, count);
}

}  // namespace credence::internal
