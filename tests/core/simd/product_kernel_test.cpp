#include "core/simd/product_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/simd/aligned_vector.h"
#include "core/simd/panel_kernel.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

std::vector<const ProductKernel*> product_kernels() {
  std::vector<const ProductKernel*> kernels;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) kernels.push_back(&product_kernel(set));
  }
  return kernels;
}

/// Rows in panels of eight, filled up with zeros: a factor on the left, or the transpose of one on the right.
AlignedVector packed_rows(const Matrix& M) {
  AlignedVector packed(static_cast<std::size_t>(whole_panels(M.rows()) * M.cols()), 0.0);
  for (Index i = 0; i < M.rows(); ++i) {
    for (Index k = 0; k < M.cols(); ++k) {
      packed[static_cast<std::size_t>(i / kPanelRows * kPanelRows * M.cols() + kPanelRows * k +
                                      i % kPanelRows)] = M(i, k);
    }
  }
  return packed;
}

constexpr Index kProductShapes[][3] = {{1, 1, 1},  {8, 8, 8},  {7, 9, 5},   {16, 3, 40},
                                       {9, 16, 2}, {3, 20, 0}, {33, 17, 12}};

// By fused multiply-adds from zero, then added; rows below the last, which belong to others, stay.
TEST(ProductKernel, IsTheSumInItsOrderToTheBitAndTouchesNothingElse) {
  for (const ProductKernel* kernel : product_kernels()) {
    for (const auto& [rows, columns, depth] : kProductShapes) {
      const Matrix A = random_matrix(rows, depth, 1), B = random_matrix(depth, columns, 2);
      const AlignedVector packed_A = packed_rows(A), packed_B = packed_rows(B.transpose());
      for (const Index gap : {0, 5}) {
        for (const bool add : {false, true}) {
          const Matrix before = random_matrix(rows + gap, columns + 1, 3);
          Matrix C = before, expected = before;
          for (Index j = 0; j < columns; ++j) {
            for (Index i = 0; i < rows; ++i) {
              double sum = 0.0;
              for (Index k = 0; k < depth; ++k) sum = std::fma(A(i, k), B(k, j), sum);
              expected(i, j) = add ? before(i, j) + sum : sum;
            }
          }
          kernel->multiply({.A = packed_A.data(),
                            .B = packed_B.data(),
                            .rows = rows,
                            .columns = columns,
                            .depth = depth,
                            .C = C.data(),
                            .stride = rows + gap,
                            .add = add,
                            .lower = false});
          EXPECT_EQ(C, expected) << rows << 'x' << columns << 'x' << depth << ", gap " << gap << add;
        }
      }
    }
  }
}

TEST(ProductKernel, OfASquareTheLowerTriangleIsAllThatNeedBeRight) {
  for (const ProductKernel* kernel : product_kernels()) {
    for (const Index n : {1, 8, 11, 24}) {
      const Matrix A = random_matrix(n, 4, 5), before = random_matrix(n + 2, n, 6);
      const AlignedVector packed = packed_rows(A);
      Matrix C = before;
      kernel->multiply({.A = packed.data(),
                        .B = packed.data(),
                        .rows = n,
                        .columns = n,
                        .depth = 4,
                        .C = C.data(),
                        .stride = n + 2,
                        .add = true,
                        .lower = true});
      for (Index j = 0; j < n; ++j) {
        for (Index i = j; i < n; ++i) {
          double sum = 0.0;
          for (Index k = 0; k < 4; ++k) sum = std::fma(A(i, k), A(j, k), sum);
          EXPECT_EQ(C(i, j), before(i, j) + sum) << n << ": " << i << ' ' << j;
        }
      }
      EXPECT_EQ(C.bottomRows(2), before.bottomRows(2));
    }
  }
}

TEST(ProductKernel, EveryInstructionSetHasAKernelOfItsOwnOrIsRefused) {
  const ProductKernel& scalar = product_kernel(InstructionSet::scalar);
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) {
      EXPECT_NE(product_kernel(set).multiply, scalar.multiply) << instruction_set_name(set);
    } else {
      EXPECT_THROW(product_kernel(set), std::invalid_argument) << instruction_set_name(set);
    }
  }
}

}  // namespace
}  // namespace credence::internal
