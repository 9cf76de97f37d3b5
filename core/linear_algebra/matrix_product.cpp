#include "core/linear_algebra/matrix_product.h"

#include <algorithm>
#include <stdexcept>

#include "core/simd/panel_kernel.h"

namespace credence::internal {
namespace {

using Panel = Eigen::Matrix<double, kPanelRows, 1>;

/// A whole panel, by vectors.
void pack_whole(const ProductFactor& M, const double* from, double* to) {
  Panel gathered;
  for (Index k = 0; k < M.columns; ++k, from += M.column_step, to += kPanelRows) {
    if (M.row_step == 1) {
      Eigen::Map<Panel>{to} = M.sign * Eigen::Map<const Panel>(from);
    } else {
      for (Index i = 0; i < kPanelRows; ++i) gathered[i] = from[i * M.row_step];
      Eigen::Map<Panel>{to} = M.sign * gathered;
    }
  }
}

/// Panels of eight rows, filled up with zeros.
void pack(const ProductFactor& M, AlignedVector& packed) {
  const Index panels = (M.rows + kPanelRows - 1) / kPanelRows;
  packed.resize(static_cast<std::size_t>(std::max<Index>(1, panels * kPanelRows * M.columns)));  // never null
  double* to = packed.data();
  for (Index row = 0; row < M.rows; row += kPanelRows) {
    const Index rows = std::min<Index>(kPanelRows, M.rows - row);
    const double* from = M.data + row * M.row_step;
    if (rows == kPanelRows) {
      pack_whole(M, from, to);
      to += kPanelRows * M.columns;
      continue;
    }
    for (Index k = 0; k < M.columns; ++k, from += M.column_step, to += kPanelRows) {
      for (Index i = 0; i < rows; ++i) to[i] = M.sign * from[i * M.row_step];
      std::fill(to + rows, to + kPanelRows, 0.0);
    }
  }
}

}  // namespace

ProductFactor ProductFactor::transposed(ProductFactor M) {
  std::swap(M.rows, M.columns);
  std::swap(M.row_step, M.column_step);
  std::swap(M.is_lower, M.is_upper);
  return M;
}

ProductFactor ProductFactor::rows_of(ProductFactor M, Index first, Index count) {
  M.data += first * M.row_step;
  M.rows = count;
  M.is_lower = M.is_upper = false;
  return M;
}

ProductFactor ProductFactor::minus(ProductFactor M) {
  M.sign = -M.sign;
  return M;
}

ProductFactor ProductFactor::lower(ProductFactor M) {
  M.is_lower = true;
  return M;
}

void MatrixProduct::multiply(Matrix& C, const ProductFactor& A, const ProductFactor& B, bool add,
                             bool lower) {
  if (A.columns != B.rows || (add && (C.rows() != A.rows || C.cols() != B.columns))) {
    throw std::invalid_argument("MatrixProduct: the shapes do not match");
  }
  if (!add) C.resize(A.rows, B.columns);
  pack(A, A_);
  pack(ProductFactor::transposed(B), B_);
  kernel_->multiply({.A = A_.data(),
                     .B = B_.data(),
                     .rows = A.rows,
                     .columns = B.columns,
                     .depth = A.columns,
                     .C = C.data(),
                     .stride = C.rows(),
                     .add = add,
                     .lower = lower,
                     .A_is_upper = A.is_upper,
                     .B_is_lower = B.is_lower});
}

}  // namespace credence::internal
