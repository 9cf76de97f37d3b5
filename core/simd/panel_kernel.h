#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind PanelCholesky, one for each instruction set. Internal: use
/// core/linear_algebra/panel_cholesky.h. Plain types only, since the files that include this are compiled for
/// more than the portable machine.
///
/// Rows come in panels of eight: element (8 p + i, k) lies at 8 k + i of panel p. The first T panels of a
/// trapezoid are the lower triangle of a symmetric matrix of 8 T rows, panel p with 8 (p + 1) columns, the
/// diagonal block stored whole; all further panels have 8 T columns.
///
/// Arithmetic, the same at every width: every sum takes its terms one by one, ascending, by fused
/// multiply-adds.

namespace credence {

inline constexpr std::int64_t kPanelRows = 8;

/// Where panel `p` of a trapezoid starts, in doubles.
constexpr std::int64_t panel_offset(std::int64_t p, std::int64_t triangle) {
  const std::int64_t blocks =
      p < triangle ? p * (p + 1) / 2 : triangle * (triangle + 1) / 2 + (p - triangle) * triangle;
  return kPanelRows * kPanelRows * blocks;
}

struct PanelTrapezoid {
  double* data;
  double* inverse;        ///< 1/L_kk
  std::int64_t triangle;  ///< T
  std::int64_t panels;    ///< in all
  std::int64_t first;     ///< panel to begin with; those before are done
  std::int64_t columns;   ///< of the 8 T, those that do not fill up the last block
};

/// The functions of one instruction set.
struct PanelKernel {
  /// The triangle S becomes L, S = L Lᵀ, and the rows below times L⁻ᵀ. False if a pivot is not positive and
  /// finite. Above the diagonal of L stands anything.
  bool (*factor)(const PanelTrapezoid&);
  /// P −= W Wᵀ for the lower triangle of a column-major P of `rows` rows, from one of whose columns to the
  /// next it is `stride`. Panel p of W starts at p panel_stride; its first `columns` columns count.
  void (*downdate)(double* P, std::int64_t rows, std::int64_t stride, const double* W,
                   std::int64_t panel_stride, std::int64_t columns);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const PanelKernel& panel_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const PanelKernel* panel_kernel_scalar();
const PanelKernel* panel_kernel_avx2();
const PanelKernel* panel_kernel_avx512();

}  // namespace credence
