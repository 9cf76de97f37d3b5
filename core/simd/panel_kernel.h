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

namespace credence::internal {

inline constexpr std::int64_t kPanelRows = 8;

/// Panels that `rows` rows need.
constexpr std::int64_t panels_of(std::int64_t rows) { return (rows + kPanelRows - 1) / kPanelRows; }
/// The rows in them.
constexpr std::int64_t whole_panels(std::int64_t rows) { return kPanelRows * panels_of(rows); }

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

/// P, column-major, and a W in panels.
struct PanelDowndate {
  double* P;
  std::int64_t rows, stride;  ///< of P
  const double* W;
  std::int64_t panel_stride, columns;  ///< panel p of W starts at p panel_stride; its first columns count
};

/// The leading columns of a block on the diagonal that are solved where so many of its eight count; those
/// that do not count must be zero below, and on the diagonal those of the identity.
constexpr std::int64_t solved_columns(std::int64_t columns) {
  return columns <= 2 ? 2 : columns <= 4 ? 4 : kPanelRows;
}

/// Columns y, padded to whole panels, and a W in panels.
struct PanelProduct {
  double* y;
  std::int64_t rows;
  const double* W;
  std::int64_t panel_stride, columns;    ///< as in PanelDowndate
  std::int64_t count = 1, y_stride = 0;  ///< of y
};

/// Columns of `rows` rows, padded to whole panels, and for each result a factor of each of them.
struct PanelCombination {
  const double* const* columns;
  std::int64_t count;
  const double* factors;  ///< those of the first result, then those of the next
  std::int64_t rows;
};

/// At most three results, of which each begins `step` doubles after the one before, and each of its panels
/// `panel_step` after the one before; they may be the columns themselves.
struct PanelResults {
  double* y;
  std::int64_t count = 1, step = 0, panel_step = kPanelRows;
};

/// What a factor says of every row of its W.
struct PanelSums {
  const double* W;
  std::int64_t rows, panel_stride, columns;  ///< as in PanelDowndate
  const double* y;
  double *squares, *product;
};

/// The functions of one instruction set.
struct PanelKernel {
  /// The triangle S becomes L, S = L Lᵀ, and the rows below times L⁻ᵀ. False if a pivot is not positive and
  /// finite. Above the diagonal of L stands anything.
  bool (*factor)(const PanelTrapezoid&);
  /// P −= W Wᵀ for the lower triangle of P. In columns without a gap all that stands above the diagonal may
  /// change, else what stands there in a block of eight by eight.
  void (*downdate)(const PanelDowndate&);
  /// Column c of y −= W wᵀ, w the row of W that is so many and c.
  void (*subtract)(const PanelProduct&, std::int64_t row);
  /// y_i −= Σ_k W_ik²; one column.
  void (*subtract_squares)(const PanelProduct&);
  /// y_j = Σ_c factors_jc columns_c; each product is rounded by itself.
  void (*combine)(const PanelCombination&, const PanelResults&);
  /// squares_i = Σ_k W_ik², product = W y; each product is rounded by itself.
  void (*sums)(const PanelSums&);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const PanelKernel& panel_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const PanelKernel* panel_kernel_scalar();
const PanelKernel* panel_kernel_avx2();
const PanelKernel* panel_kernel_avx512();

}  // namespace credence::internal
