#include "core/linear_algebra/panel_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// Positive definite, m×m, with nonsense above its diagonal.
Matrix lower_of_positive(Index m) {
  const Matrix A = random_matrix(m, m, 3);
  Matrix S = A * A.transpose() + Matrix::Identity(m, m);
  S.triangularView<Eigen::StrictlyUpper>().setConstant(17.0);
  return S;
}

TEST(PanelCholesky, is_the_factorisation_at_every_size) {
  PanelCholesky factor;  // one for all, so that what a larger problem left behind shows
  for (const Index m : {40, 1, 2, 7, 8, 9, 16, 33}) {
    for (const Index n : {0, 5, 8, 41}) {
      const Matrix S = lower_of_positive(m), Y = random_matrix(n, m, 5);
      const Vector nu = random_matrix(m, 1, 7);
      const Matrix full = S.selfadjointView<Eigen::Lower>();
      const Eigen::LLT<Matrix> expected(full);
      ASSERT_TRUE(factor.compute(S, Y, nu));
      const Matrix L = expected.matrixL();
      EXPECT_LT((factor.L() - L).cwiseAbs().maxCoeff(), 1e-12 * L.cwiseAbs().maxCoeff()) << m << " " << n;
      EXPECT_EQ(factor.pivot(m - 1), factor.L()(m - 1, m - 1));
      const Vector y = L.triangularView<Eigen::Lower>().solve(nu);
      EXPECT_LT((factor.whitened() - y).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_NEAR(factor.log_determinant(), 2.0 * L.diagonal().array().log().sum(),
                  1e-11 * static_cast<double>(m));
      if (n > 0) {
        const Matrix W = L.triangularView<Eigen::Lower>().solve(Y.transpose()).transpose();
        EXPECT_LT((factor.W() - W).cwiseAbs().maxCoeff(), 1e-11);
        EXPECT_LT((factor.gain() - expected.solve(Y.transpose()).transpose()).cwiseAbs().maxCoeff(), 1e-10);
        Vector squares, product;
        factor.sums(squares, product);
        EXPECT_LT((squares.head(n) - W.rowwise().squaredNorm()).cwiseAbs().maxCoeff(), 1e-10);
        EXPECT_LT((product.head(n) - W * y).cwiseAbs().maxCoeff(), 1e-10);

        // Whole columns, of a block of a larger matrix whose other elements stay.
        const Index columns = n - n / 3;
        const Matrix large = random_matrix(n + 3, n + 1, 11);
        Matrix corrected = large;
        factor.downdate_columns(corrected.topLeftCorner(n, columns));
        Matrix wanted = large;
        wanted.topLeftCorner(n, columns) -= W * W.topRows(columns).transpose();
        EXPECT_LT((corrected - wanted).cwiseAbs().maxCoeff(), 1e-10);
        EXPECT_EQ(corrected.rightCols(n + 1 - columns), large.rightCols(n + 1 - columns));
        EXPECT_EQ(corrected.bottomRows(3), large.bottomRows(3));
        Vector x = nu.replicate(n, 1).topRows(n);
        const Vector expected_x = x + W * y;
        factor.add_correction(x);
        EXPECT_LT((x - expected_x).cwiseAbs().maxCoeff(), 1e-10);
      }
      const Matrix inverse = expected.solve(Matrix::Identity(m, m));
      EXPECT_LT((factor.inverse_diagonal() - inverse.diagonal()).cwiseAbs().maxCoeff(), 1e-11);
    }
  }
}

TEST(PanelCholesky, no_bit_depends_on_the_instruction_set) {
  const Index n = 45;
  for (const Index m : {1, 2, 29}) {
    const Matrix S = lower_of_positive(m), Y = random_matrix(n, m, 5), prior = lower_of_positive(n);
    const Vector nu = random_matrix(m, 1, 7);
    PanelCholesky expected(InstructionSet::scalar);
    ASSERT_TRUE(expected.compute(S, Y, nu));
    Vector squares_expected, product_expected;
    expected.sums(squares_expected, product_expected);
    Matrix columns_expected = prior;
    expected.downdate_columns(columns_expected.leftCols(21));
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      PanelCholesky factor(set);
      ASSERT_TRUE(factor.compute(S, Y, nu));
      EXPECT_EQ(factor.L(), expected.L()) << instruction_set_name(set);
      EXPECT_EQ(factor.W(), expected.W());
      EXPECT_EQ(factor.whitened(), expected.whitened());
      Vector squares, product;
      factor.sums(squares, product);
      EXPECT_EQ(squares.head(n), squares_expected.head(n));
      EXPECT_EQ(product.head(n), product_expected.head(n));
      Matrix P = prior;
      factor.downdate_columns(P.leftCols(21));
      EXPECT_EQ(P, columns_expected);
    }
  }
}

// Each product and each sum is rounded, in the order of the columns, by every instruction set.
TEST(PanelCholesky, combines_columns_as_a_loop_does) {
  for (const Index n : {1, 7, 8, 21}) {
    const Matrix columns = random_matrix(whole_panels(n), 5, 3);
    const Vector factors = random_matrix(5, 1, 4);
    Vector expected = Vector::Zero(n);
    std::vector<const double*> from;
    for (Index c = 0; c < columns.cols(); ++c) {
      from.push_back(columns.col(c).data());
      for (Index i = 0; i < n; ++i) expected[i] = expected[i] + factors[c] * columns(i, c);
    }
    for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      Vector y(whole_panels(n));
      PanelCholesky(set).combine(from, factors.data(), n, {.y = y.data()});
      EXPECT_EQ(y.head(n), expected) << instruction_set_name(set) << " " << n;
    }
  }
}

// Whether Y is copied or written where it is wanted, a larger factor before or not.
TEST(PanelCholesky, takes_what_is_placed_in_it_as_what_is_copied) {
  PanelCholesky copied, placed;
  for (const auto& [m, n] : {std::pair<Index, Index>{11, 30}, {2, 16}, {3, 7}, {6, 24}, {2, 5}, {20, 9}}) {
    const Matrix S = lower_of_positive(m), Y = random_matrix(n, m, 5);
    const Vector nu = random_matrix(m, 1, 7);
    ASSERT_TRUE(copied.compute(S, Y, nu));
    double* panels = placed.place(m, n);
    for (Index i = 0; i < whole_panels(n); ++i) {
      double* row = panels + i / kPanelRows * placed.solved_panel_stride() + i % kPanelRows;
      for (Index k = 0; k < m; ++k) row[kPanelRows * k] = i < n ? Y(i, k) : 0.0;
    }
    ASSERT_TRUE(placed.compute_placed(S, nu));
    EXPECT_EQ(placed.W(), copied.W()) << m << " " << n;
    EXPECT_EQ(placed.whitened(), copied.whitened()) << m << " " << n;
  }
  EXPECT_THROW(placed.compute_placed(Matrix::Identity(2, 2), Vector::Zero(2)), std::invalid_argument);
}

// What a larger factor left behind is in no smaller one.
TEST(PanelCholesky, forgets_the_factors_before) {
  PanelCholesky used, fresh;
  for (const auto& [m, n] : {std::pair<Index, Index>{11, 30}, {11, 3}, {3, 40}, {11, 40}, {10, 9}}) {
    const Matrix S = lower_of_positive(m), Y = random_matrix(n, m, 5);
    const Vector nu = random_matrix(m, 1, 7);
    used.compute(S, Matrix::Constant(n, m, std::nan("")), nu);
    ASSERT_TRUE(used.compute(S, Y, nu));
    fresh = PanelCholesky();
    ASSERT_TRUE(fresh.compute(S, Y, nu));
    EXPECT_EQ(used.W(), fresh.W()) << m << " " << n;
    EXPECT_EQ(used.whitened(), fresh.whitened());
    Matrix P = Matrix::Zero(n, n), expected = P;
    used.downdate_columns(P);
    fresh.downdate_columns(expected);
    EXPECT_EQ(P, expected);
    EXPECT_EQ(Vector(used.inverse_diagonal()), Vector(fresh.inverse_diagonal()));
  }
}

TEST(PanelCholesky, what_is_not_positive_definite_is_said_to_be) {
  PanelCholesky factor;
  for (const double bad : {-1.0, 0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const Index at : {0, 9, 19}) {
      Matrix S = Matrix::Identity(20, 20);
      S(at, at) = bad;
      EXPECT_FALSE(factor.compute(S, Vector::Ones(20))) << bad << " " << at;
    }
  }
  EXPECT_TRUE(factor.compute(Matrix::Identity(20, 20), Vector::Ones(20)));
}

TEST(PanelCholesky, shapes_that_do_not_match_are_refused) {
  PanelCholesky factor;
  const Matrix I = Matrix::Identity(4, 4);
  EXPECT_THROW(factor.compute(I, Vector::Ones(3)), std::invalid_argument);
  EXPECT_THROW(factor.compute(I, Matrix::Ones(5, 3), Vector::Ones(4)), std::invalid_argument);
  ASSERT_TRUE(factor.compute(I, Matrix::Ones(5, 4), Vector::Ones(4)));
  Matrix P = I;
  EXPECT_THROW(factor.downdate_columns(P), std::invalid_argument);
  P.resize(5, 6);
  EXPECT_THROW(factor.downdate_columns(P), std::invalid_argument);
  Vector x = Vector::Zero(4);
  EXPECT_THROW(factor.add_correction(x), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
