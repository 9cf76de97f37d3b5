#pragma once

#include <cstddef>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind core/manifold/trigonometry.h, one for each instruction set. Plain types only,
/// since the files that include this are compiled for more than the portable machine.

namespace credence::internal {

/// The function of one instruction set. It returns how many elements it did from the front; the next few, at
/// most a pack, hold one that takes the long way.
struct TrigonometryKernel {
  std::size_t (*arc_tangents)(const double* y, const double* x, double* out, std::size_t count);
  std::size_t lanes;  ///< elements of a pack
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const TrigonometryKernel& trigonometry_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const TrigonometryKernel* trigonometry_kernel_scalar();
const TrigonometryKernel* trigonometry_kernel_avx2();
const TrigonometryKernel* trigonometry_kernel_avx512();

/// arc_tangents of core/manifold/trigonometry.h by one kernel.
void arc_tangents_by(const TrigonometryKernel& kernel, const double* y, const double* x, double* out,
                     std::size_t count);

}  // namespace credence::internal
