#pragma once

#include "core/simd/aligned_vector.h"
#include "core/simd/product_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// A factor of a product: a matrix, rows of it, minus it, or the transpose of one of these.
struct ProductFactor {
  const double* data;
  Index rows, columns, row_step, column_step;
  double sign = 1.0;
  bool is_lower = false, is_upper = false;  ///< triangular, square, its zeros stored: products skip them

  ProductFactor(const Matrix& M)
      : data(M.data()), rows(M.rows()), columns(M.cols()), row_step(1), column_step(M.rows()) {}
  /// Of a factor that is itself a transpose: the matrix.
  static ProductFactor transposed(ProductFactor M);
  /// `count` rows of a factor.
  static ProductFactor rows_of(ProductFactor M, Index first, Index count);
  static ProductFactor minus(ProductFactor M);
  /// Of a lower triangular matrix.
  static ProductFactor lower(ProductFactor M);
};

/// Products of dense matrices at the speed of the machine's widest registers and with the same bits on every
/// machine, which a library's products do not have: every element is the sum over k, ascending, by fused
/// multiply-adds. Keeps its memory, so that a product of no larger size allocates nothing.
class MatrixProduct {
 public:
  /// Throws std::invalid_argument if this machine does not support `set`.
  explicit MatrixProduct(InstructionSet set = best_instruction_set()) : kernel_(&product_kernel(set)) {}

  /// C = A B. C is resized and must be none of the factors. Throws std::invalid_argument for shapes that do
  /// not match.
  void set(Matrix& C, const ProductFactor& A, const ProductFactor& B) { multiply(C, A, B, false, false); }

  /// C += A B. C has the shape of A B and is none of the factors.
  void add(Matrix& C, const ProductFactor& A, const ProductFactor& B) { multiply(C, A, B, true, false); }

  /// C = A B for a symmetric product: only the lower triangle of C is good afterwards.
  void set_lower(Matrix& C, const ProductFactor& A, const ProductFactor& B) {
    multiply(C, A, B, false, true);
  }

  /// C += A B for a symmetric sum: only the lower triangle of C is good afterwards. C has the shape of A B.
  void add_lower(Matrix& C, const ProductFactor& A, const ProductFactor& B) { multiply(C, A, B, true, true); }

 private:
  void multiply(Matrix& C, const ProductFactor& A, const ProductFactor& B, bool add, bool lower);

  const ProductKernel* kernel_;
  AlignedVector A_, B_;  ///< packed
};

}  // namespace credence::internal
