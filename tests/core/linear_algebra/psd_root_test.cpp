#include "core/linear_algebra/psd_root.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/nan.h"

namespace credence::internal {
namespace {

Matrix identity(Index n) { return Matrix::Identity(n, n); }

TEST(PsdRoot, RootsGiveTheMatrixBack) {
  const Matrix regular = (Matrix(2, 2) << 4, 1, 1, 3).finished();
  const Matrix singular = (Matrix(2, 2) << 0.1, 0.3, 0.3, 0.9).finished();
  for (const Matrix& A : {regular, singular, Matrix(Matrix::Zero(2, 2))}) {
    EXPECT_LT((psd_root(A) * psd_root(A).transpose() - A).norm(), 1e-15);
  }
}

TEST(PsdWhitening, OfARegularMatrixIsTheInverseFactor) {
  const Matrix A = (Matrix(3, 3) << 4, 1, 0, 1, 3, 0.5, 0, 0.5, 1e-20).finished();
  const Matrix W = psd_whitening(Matrix(A.topLeftCorner(2, 2)));
  EXPECT_TRUE(W.isLowerTriangular(0.0));
  EXPECT_LT((W * A.topLeftCorner(2, 2) * W.transpose() - identity(2)).norm(), 1e-15);
}

// A rank in metres is one in light years: diag(1, 1e-12) is regular, and so is what it is scaled to.
TEST(PsdWhitening, RanksDependOnNoUnits) {
  const Matrix unit = (Matrix(2, 2) << 1, 0.5, 0.5, 1).finished();
  const Vector scale = (Vector(2) << 1e6, 1e-7).finished();
  const Matrix A = scale.asDiagonal() * unit * scale.asDiagonal();
  const Matrix W = psd_whitening(A);
  ASSERT_EQ(W.rows(), 2);
  EXPECT_LT((W * A * W.transpose() - identity(2)).norm(), 1e-14);
}

// 0.9 − 0.3²/0.1 is not 0 in doubles, but some rounding of either sign.
TEST(PsdWhitening, RoundingIsNoRank) {
  for (int i = 1; i < 200; ++i) {
    const Vector v = (Vector(3) << 0.1 * i, 0.3, -0.7 / i).finished();
    const Matrix A = v * v.transpose();
    const Matrix W = psd_whitening(A);
    ASSERT_EQ(W.rows(), 1) << i;
    EXPECT_NEAR((W * v).squaredNorm(), 1.0, 1e-12) << i;
    const Matrix two = A + Vector::Unit(3, 1) * Vector::Unit(3, 1).transpose();
    ASSERT_EQ(psd_whitening(two).rows(), 2) << i;
  }
}

TEST(IsPsd, TakesRoundingForNothingAndAllElseForIndefinite) {
  const auto correlated = [](double covariance) {
    return Matrix((Matrix(2, 2) << 1e-6, covariance, covariance, 1e6).finished());
  };
  EXPECT_TRUE(is_psd(correlated(0.5)));
  EXPECT_TRUE(is_psd(correlated(1.0)));
  EXPECT_TRUE(is_psd(correlated(1.0 + 1e-15)));
  EXPECT_FALSE(is_psd(correlated(1.0 + 1e-11)));
  EXPECT_TRUE(is_psd(correlated(1.0 + 1e-11), 1e-10));
  EXPECT_FALSE(is_psd(correlated(std::nan(""))));
  EXPECT_FALSE(is_psd(-correlated(0.5)));
  EXPECT_FALSE(is_psd((Matrix(2, 2) << 0, 1, 1, 1).finished()));
  EXPECT_TRUE(is_psd((Matrix(2, 2) << 0, 0, 0, 1).finished()));
  EXPECT_TRUE(is_psd(Matrix(0, 0)));
}

TEST(PsdWhitening, StatesWithoutVarianceAreLeftOut) {
  Matrix A = Matrix::Zero(3, 3);
  A(0, 0) = 4.0;
  A(2, 2) = 1e-33;  // (1 − K)² P with K = 1 to rounding
  const Vector before = (Vector(3) << 5, 0, 2).finished();
  EXPECT_EQ(states_with_variance(A, before), std::vector<Index>{0});
  // A variance that was as small before the measurement is one.
  EXPECT_EQ(states_with_variance(A, before * 1e-33), (std::vector<Index>{0, 2}));
  EXPECT_EQ(psd_whitening(A).rows(), 2);
  const Matrix W = psd_whitening(A, before);
  ASSERT_EQ(W.rows(), 1);
  EXPECT_EQ(W, (Matrix(1, 3) << 0.5, 0, 0).finished());
  EXPECT_EQ(psd_whitening(Matrix(Matrix::Zero(2, 2))).rows(), 0);
  EXPECT_EQ(psd_whitening(Matrix(0, 0)).rows(), 0);
  Matrix cleared = A;
  clear_rounded_variances(cleared, before);
  EXPECT_EQ(cleared, (Matrix(3, 3) << A(0, 0), 0, 0, 0, 0, 0, 0, 0, 0).finished());
  cleared = A;
  clear_rounded_variances(cleared, before * 1e-33);
  EXPECT_EQ(cleared(2, 2), A(2, 2));
  cleared(0, 0) = kNaN;
  clear_rounded_variances(cleared, before);
  EXPECT_TRUE(std::isnan(cleared(0, 0))) << "what is no number is not hidden";
}

}  // namespace
}  // namespace credence::internal
