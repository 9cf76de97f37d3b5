#include "core/filters/joseph_update.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/linear_algebra/cholesky.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// T P Tᵀ + K R Kᵀ, R block diagonal of equal blocks, with 64 bits of mantissa.
Wide joseph_by_definition(const Matrix& P, const Matrix& H, const Matrix& K, const Matrix& R) {
  const Wide T = Wide::Identity(P.rows(), P.cols()) - K.cast<long double>() * H.cast<long double>();
  Wide whole = Wide::Zero(K.cols(), K.cols());
  for (Index i = 0; i < K.cols(); i += R.cols())
    whole.block(i, i, R.rows(), R.cols()) = R.cast<long double>();
  return T * P.cast<long double>() * T.transpose() +
         K.cast<long double>() * whole * K.transpose().cast<long double>();
}

/// A problem whose H touches some of the states alone.
struct SparseUpdate {
  Matrix P, H, K, R;

  SparseUpdate(Index n, Index m, const std::vector<Index>& touched, double R_scale, std::uint64_t seed) {
    const Matrix root = random_matrix(n, n, seed);
    P = root * root.transpose();
    H = Matrix::Zero(m, n);
    for (const Index j : touched) H.col(j) = random_matrix(m, 1, ++seed);
    R = R_scale * (Matrix(2, 2) << 2.0, 0.3, 0.3, 1.0).finished();
    Matrix S = H * P * H.transpose();
    for (Index i = 0; i < m; i += 2) S.block<2, 2>(i, i) += R;
    const Matrix HP = H * P;
    K = Eigen::LLT<Matrix>(S).solve(HP).transpose();
  }
};

// Of any gain, the best one or not: Joseph's form is the covariance of the error that this gain leaves.
TEST(JosephUpdate, IsItsDefinitionForAnyGain) {
  std::uint64_t seed = 5;
  JosephUpdate update;
  for (const auto& touched : {std::vector<Index>{1, 4}, {0, 2, 5, 6}, {}, {0, 1, 2, 3, 4, 5, 6}}) {
    for (const bool best : {true, false}) {
      SparseUpdate at(7, 4, touched, 1.0, seed += 10);
      if (!best) at.K = random_matrix(7, 4, ++seed);
      Matrix P = at.P;
      update.apply(P, at.H, at.K, at.R);
      const Matrix expected = joseph_by_definition(at.P, at.H, at.K, at.R).cast<double>();
      EXPECT_LT((P - expected).norm(), 1e-13 * (1.0 + expected.norm())) << touched.size() << best;
      EXPECT_EQ(P, P.transpose());
    }
  }
}

// A measurement 10¹² times as exact as the prior, of two states: what is left of its variance is R,
// and P − K H P would leave rounding of the prior's size, 10⁻¹⁶, which is a tenth of a thousandth of it.
TEST(JosephUpdate, KeepsTheDigitsOfAnExactMeasurement) {
  SparseUpdate at(6, 2, {2, 3}, 1e-12, 8);
  const Matrix expected = joseph_by_definition(at.P, at.H, at.K, at.R).cast<double>();
  Matrix P = at.P, plain = at.P - at.K * at.H * at.P;
  JosephUpdate().apply(P, at.H, at.K, at.R);
  const auto error_of = [&](const Matrix& of) {
    return (of - expected).block(2, 2, 2, 2).norm() / expected.block(2, 2, 2, 2).norm();
  };
  EXPECT_LT(error_of(P), 1e-10);
  EXPECT_GT(error_of(plain), 1e-8);  // which is why
}

// Its memory is that of the largest update so far; a smaller one after it must not see what was there.
TEST(JosephUpdate, ASmallUpdateAfterALargeOneIsTheSame) {
  const SparseUpdate large(9, 6, {0, 3, 4, 8}, 1.0, 11), small(4, 2, {1}, 1.0, 12);
  JosephUpdate kept;
  Matrix P = large.P, again = small.P, fresh = small.P;
  kept.apply(P, large.H, large.K, large.R);
  kept.apply(again, small.H, small.K, small.R);
  JosephUpdate().apply(fresh, small.H, small.K, small.R);
  EXPECT_EQ(again, fresh);
}

}  // namespace
}  // namespace credence::internal
