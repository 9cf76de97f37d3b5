#include "core/linear_algebra/matrix_product.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// As the header says: over k, ascending, by fused multiply-adds.
Matrix by_definition(const Matrix& A, const Matrix& B) {
  Matrix C = Matrix::Zero(A.rows(), B.cols());
  for (Index i = 0; i < C.rows(); ++i) {
    for (Index j = 0; j < C.cols(); ++j) {
      for (Index k = 0; k < A.cols(); ++k) C(i, j) = std::fma(A(i, k), B(k, j), C(i, j));
    }
  }
  return C;
}

std::vector<InstructionSet> sets() {
  std::vector<InstructionSet> all;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) all.push_back(set);
  }
  return all;
}

constexpr Index kShapes[][3] = {{1, 1, 1}, {8, 8, 8}, {7, 9, 5}, {16, 3, 40}, {33, 17, 65}, {3, 50, 0}};

TEST(MatrixProduct, is_the_sum_in_its_order_to_the_bit) {
  for (const InstructionSet set : sets()) {
    MatrixProduct multiply(set);  // its memory is used again for other shapes
    for (const auto& [rows, columns, depth] : kShapes) {
      const Matrix A = random_matrix(rows, depth, 1), B = random_matrix(depth, columns, 2);
      const Matrix expected = by_definition(A, B);
      Matrix C;
      multiply.set(C, A, B);
      EXPECT_EQ(C, expected) << instruction_set_name(set) << ' ' << rows << 'x' << columns << 'x' << depth;
      const Matrix A_t = A.transpose(), B_t = B.transpose();
      multiply.set(C, ProductFactor::transposed(A_t), ProductFactor::transposed(B_t));
      EXPECT_EQ(C, expected) << instruction_set_name(set);
    }
  }
}

TEST(MatrixProduct, a_lower_triangle_is_added_to) {
  for (const InstructionSet set : sets()) {
    MatrixProduct multiply(set);
    for (const Index n : {1, 8, 13, 40}) {
      const Matrix A = random_matrix(n, n / 2, 3), start = random_matrix(n, n, 4);
      const Matrix expected = start + by_definition(A, A.transpose());
      Matrix C = start;
      multiply.add_lower(C, A, ProductFactor::transposed(A));
      for (Index j = 0; j < n; ++j) {
        for (Index i = j; i < n; ++i) EXPECT_EQ(C(i, j), expected(i, j)) << i << ' ' << j;
      }
    }
  }
}

TEST(MatrixProduct, rows_and_the_opposite_of_a_factor_are_factors) {
  for (const InstructionSet set : sets()) {
    MatrixProduct multiply(set);
    const Matrix A = random_matrix(23, 7, 8), B = random_matrix(7, 11, 9), start = random_matrix(10, 11, 10);
    const Matrix product = by_definition(A.middleRows(5, 10), B);
    Matrix C = start;
    multiply.add(C, ProductFactor::rows_of(A, 5, 10), B);
    EXPECT_EQ(C, start + product);
    C = start;
    multiply.add(C, ProductFactor::minus(ProductFactor::rows_of(A, 5, 10)), B);
    EXPECT_EQ(C, start - product);
    const Matrix A_t = A.transpose();
    C = start;
    multiply.add(C, ProductFactor::rows_of(ProductFactor::transposed(A_t), 5, 10), B);
    EXPECT_EQ(C, start + product);
  }
}

TEST(MatrixProduct, of_triangles_is_that_of_their_zeros) {
  for (const InstructionSet set : sets()) {
    MatrixProduct multiply(set);
    for (const Index n : {1, 8, 13, 40}) {
      const Matrix L = random_matrix(n, n, 11).triangularView<Eigen::Lower>(), U = L.transpose();
      const Matrix B = random_matrix(n, n, 12);
      Matrix C;
      multiply.set(C, B, ProductFactor::lower(L));
      EXPECT_EQ(C, by_definition(B, L)) << n;
      multiply.set(C, ProductFactor::lower(L), B);
      EXPECT_EQ(C, by_definition(L, B)) << n;
      multiply.set(C, ProductFactor::transposed(ProductFactor::lower(L)), B);
      EXPECT_EQ(C, by_definition(U, B)) << n;
      const Matrix expected = by_definition(U, L);
      multiply.set_lower(C, ProductFactor::transposed(ProductFactor::lower(L)), ProductFactor::lower(L));
      for (Index j = 0; j < n; ++j) {
        for (Index i = j; i < n; ++i) EXPECT_EQ(C(i, j), expected(i, j)) << i << ' ' << j;
      }
    }
  }
}

TEST(MatrixProduct, what_is_not_finite_stays_where_it_is) {
  Matrix A = random_matrix(9, 9, 5);
  A(4, 3) = std::nan("");
  Matrix C;
  MatrixProduct().set(C, A, Matrix(Matrix::Identity(9, 9)));
  for (Index i = 0; i < 9; ++i) EXPECT_EQ(C.row(i).hasNaN(), i == 4);
}

TEST(MatrixProduct, shapes_that_do_not_match_are_refused) {
  MatrixProduct multiply;
  Matrix C = Matrix::Zero(3, 3);
  EXPECT_THROW(multiply.set(C, Matrix(3, 2), Matrix(3, 3)), std::invalid_argument);
  EXPECT_THROW(multiply.add_lower(C, Matrix(2, 2), Matrix(2, 2)), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
