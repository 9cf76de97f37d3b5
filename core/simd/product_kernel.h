#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// The compiled kernels behind MatrixProduct, one for each instruction set. Internal: use
/// core/linear_algebra/matrix_product.h. Plain types only, since the files that include this are compiled for
/// more than the portable machine.

namespace credence::internal {

/// A product C = A B of packed factors. Rows of A and columns of B come in panels of eight, filled up with
/// zeros: element (8 p + i, k) of A at 8 (p depth + k) + i, element (k, 8 q + j) of B at 8 (q depth + k) + j.
struct PackedProduct {
  const double* A;
  const double* B;
  std::int64_t rows, columns, depth;
  double* C;                ///< column-major
  std::int64_t stride;      ///< from one column of C to the next
  bool add;                 ///< to what C is
  bool lower;               ///< of a square C: what lies above the diagonal may get any value
  bool A_is_upper = false;  ///< triangular, so that the sum of a row begins at its own k
  bool B_is_lower = false;  ///< the same of a column
};

/// The functions of one instruction set.
struct ProductKernel {
  /// Every element is the sum over k, ascending, by fused multiply-adds from zero, then added.
  void (*multiply)(const PackedProduct&);
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const ProductKernel& product_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const ProductKernel* product_kernel_scalar();
const ProductKernel* product_kernel_avx2();
const ProductKernel* product_kernel_avx512();

}  // namespace credence::internal
