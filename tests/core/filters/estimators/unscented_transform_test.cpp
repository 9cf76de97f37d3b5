#include "core/filters/estimators/unscented_transform.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/weighted_points.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

Vector curved(const Vector& x) {
  return Eigen::Vector3d(x[0] * x[1] + std::sin(x[2]), std::exp(0.3 * x[0]) - x[3], x.squaredNorm());
}

Matrix spread_of_four() {
  const Matrix A = random_matrix(4, 4, 3);
  return 0.1 * A * A.transpose() + 0.05 * Matrix::Identity(4, 4);
}

TEST(UnscentedTransform, is_the_weighted_sum_over_its_sigma_points) {
  const Vector x = random_matrix(4, 1, 2);
  const Matrix P = spread_of_four(), L = P.llt().matrixL();
  Matrix lower = P;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(99.0);
  for (const double alpha : {0.1, 0.5, 1.0}) {
    UnscentedTransform transform;
    transform.take(lower, 3, alpha,
                   [&](const VectorRef& step, Eigen::Ref<Vector> y) { y = curved(x + step) - curved(x); });
    const WeightedPoints expected(curved, x, L, alpha);
    EXPECT_LT((transform.root() - L).norm(), 1e-14);
    EXPECT_LT((curved(x) + transform.shift() - expected.mean).norm(), 1e-11);
    const Matrix covariance = transform.D() * transform.D().transpose() + transform.curvature();
    EXPECT_LT((covariance - expected.covariance).norm(), 1e-11) << alpha;
    EXPECT_LT((transform.root() * transform.D().transpose() - expected.cross).norm(), 1e-11);
  }
}

// Of a quadratic form the mean is known, tr A P for xᵀ A x; the covariance has a term of second order in P.
TEST(UnscentedTransform, has_the_mean_of_a_quadratic_form_however_small_the_spread) {
  const Matrix P = spread_of_four(), A = Vector::LinSpaced(4, 1.0, 4.0).asDiagonal();
  for (const double alpha : {1e-4, 1e-2, 1.0}) {
    UnscentedTransform transform;
    transform.take(P, 1, alpha,
                   [&](const VectorRef& step, Eigen::Ref<Vector> y) { y[0] = step.dot(A * step); });
    EXPECT_NEAR(transform.shift()[0], (A * P).trace(), 1e-9);
    EXPECT_NEAR(transform.D().norm(), 0.0, 1e-12);
  }
}

// Scalar case of the scaled transform: Var x² = 2 P² exactly with β = 2.
TEST(UnscentedTransform, has_the_variance_of_a_gaussian_square) {
  for (const double alpha : {1e-3, 0.3, 1.0}) {
    UnscentedTransform transform;
    transform.take(Matrix::Constant(1, 1, 0.7), 1, alpha,
                   [](const VectorRef& step, Eigen::Ref<Vector> y) { y[0] = step[0] * step[0]; });
    EXPECT_NEAR(transform.shift()[0], 0.7, 1e-12);
    EXPECT_NEAR(transform.curvature()(0, 0), 2.0 * 0.49, 1e-12) << alpha;
  }
}

TEST(SemidefiniteRoot, gives_the_matrix_back_and_zeros_where_nothing_is_spread) {
  for (const Index rank : {0, 1, 3, 5}) {
    const Matrix A = random_matrix(5, rank, 8);
    const Matrix P = rank == 0 ? Matrix(Matrix::Zero(5, 5)) : Matrix(A * A.transpose());
    Matrix L = P;
    L.triangularView<Eigen::StrictlyUpper>().setConstant(-7.0);
    semidefinite_root(L);
    EXPECT_LT((L * L.transpose() - P).norm(), 1e-12);
    EXPECT_EQ(L.triangularView<Eigen::StrictlyUpper>().toDenseMatrix().norm(), 0.0);
    for (Index j = rank; j < 5; ++j) EXPECT_EQ(L.col(j).norm(), 0.0) << rank;
  }
  Matrix with_gap = Matrix::Zero(3, 3);  // a state without variance between others
  with_gap(0, 0) = 4.0;
  with_gap(2, 0) = 2.0;
  with_gap(2, 2) = 10.0;
  semidefinite_root(with_gap);
  Matrix expected(3, 3);
  expected << 2, 0, 0, 0, 0, 0, 1, 0, 3;
  EXPECT_EQ(with_gap, expected);
}

// Where the pivots differ by ten orders of magnitude none of them is rounding.
TEST(SemidefiniteRoot, does_not_depend_on_units) {
  const Matrix P = spread_of_four();
  const Vector units(Eigen::Vector4d(0x1p-60, 0x1p40, 1.0, 0x1p-20));
  Matrix L = P, scaled = units.asDiagonal() * P * units.asDiagonal();
  semidefinite_root(L);
  semidefinite_root(scaled);
  EXPECT_EQ(scaled, Matrix(units.asDiagonal() * L));
}

TEST(DivideByRoot, gives_back_what_was_multiplied) {
  const Matrix X = random_matrix(3, 4, 1);
  Matrix L = spread_of_four();
  semidefinite_root(L);
  Matrix D = X * L;
  divide_by_root(D, L);
  EXPECT_LT((D - X).norm(), 1e-12);

  L.col(1).setZero();  // free: left to who put it there
  D = X * L;
  const Vector free = random_matrix(3, 1, 4);
  D.col(1) = free;
  divide_by_root(D, L);
  EXPECT_EQ(D.col(1), free);
  Matrix product = X * L;
  EXPECT_LT((D * L - product).norm(), 1e-12);
}

}  // namespace
}  // namespace credence::internal
