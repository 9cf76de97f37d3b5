#include "core/linear_algebra/matrix_product.h"

#include <algorithm>
#include <stdexcept>

#include "core/simd/panel_kernel.h"

namespace credence::internal {
namespace {

/// Panels of eight rows, filled up with zeros.
void pack(const ProductFactor& M, AlignedVector& packed) {
  const Index panels = (M.rows + kPanelRows - 1) / kPanelRows;
  packed.resize(static_cast<std::size_t>(std::max<Index>(1, panels * kPanelRows * M.columns)));  // never null
  double* to = packed.data();
  for (Index row = 0; row < M.rows; row += kPanelRows) {
    const Index rows = std::min<Index>(kPanelRows, M.rows - row);
    for (Index k = 0; k < M.columns; ++k, to += kPanelRows) {
      const double* from = M.data + row * M.row_step + k * M.column_step;
      for (Index i = 0; i < rows; ++i) to[i] = from[i * M.row_step];
      std::fill(to + rows, to + kPanelRows, 0.0);
    }
  }
}

}  // namespace

ProductFactor ProductFactor::transposed(ProductFactor M) {
  std::swap(M.rows, M.columns);
  std::swap(M.row_step, M.column_step);
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
                     .lower = lower});
}

}  // namespace credence::internal
