#include "analysis/stability/riccati_doubling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::scalar_problem;

TEST(RiccatiMap, OfAConstantIsItsClosedForm) {
  // f = h = r = 1, q = 0: P after k steps is p/(1 + k p), and the error shrinks by 1/(1 + k p).
  const double p = 0.25;
  RiccatiMap map(scalar_problem(1, 1, 0), testing::matrix_1x1(p));
  double steps = 1.0;
  for (int k = 0; k <= 10; ++k, steps *= 2.0) {
    EXPECT_EQ(map.doublings(), k);
    EXPECT_NEAR(map.after_centre()(0, 0), p / (1.0 + steps * p), 1e-12) << steps;
    EXPECT_NEAR(map.A()(0, 0), 1.0 / (1.0 + steps * p), 1e-12) << steps;
    for (const double other : {0.0, 0.1, 4.0})
      EXPECT_NEAR(map.after(testing::matrix_1x1(other))(0, 0), other / (1.0 + steps * other), 1e-13) << steps;
    if (k > 0) {
      const double theta = p / (1.0 + steps * p) - p, before = p / (1.0 + 0.5 * steps * p) - p;
      EXPECT_NEAR(map.last_change(), (before - theta) / -theta, 1e-12);
    }
    ASSERT_TRUE(map.square());
  }
}

TEST(RiccatiMap, OfFewMeasurementsIsThatOfManySteps) {
  // One measurement of twelve states: Γ has rank 1, 2, 4 and 8, and then a Cholesky factor.
  std::mt19937_64 generator(21);
  const Index n = 12;
  const RiccatiProblem problem{testing::random_matrix(n, n, generator) / 4.0,
                               testing::random_matrix(1, n, generator), testing::random_psd(n, 3, generator),
                               Matrix::Identity(1, 1)};
  const Matrix P0 = testing::random_psd(n, n, generator);
  RiccatiMap map(problem), around(problem, P0);
  for (int k = 0; k < 5; ++k) {
    const Matrix P = testing::iterated(problem, P0, 1 << k), zero = Matrix::Zero(n, n);
    EXPECT_LT((map.after(P0) - P).norm(), 1e-10 * P.norm()) << k;
    EXPECT_LT((around.after(P0) - P).norm(), 1e-10 * P.norm()) << k;
    EXPECT_LT((map.Theta() - testing::iterated(problem, zero, 1 << k)).norm(), 1e-10 * P.norm()) << k;
    RiccatiMap copy = map;
    const Matrix next = copy.next_Theta();
    ASSERT_TRUE(map.square() && around.square());
    EXPECT_LT((next - map.Theta()).norm(), 1e-12 * next.norm()) << k;
    EXPECT_EQ(map.Theta(), Matrix(map.Theta().transpose()));
  }
}

TEST(RiccatiMap, OfWhatIsNeverSeenHasNoFactor) {
  // The last of three states is by itself and not measured: Γ stays singular.
  std::mt19937_64 generator(22);
  Matrix F = 0.5 * testing::random_matrix(3, 3, generator), H = testing::random_matrix(4, 3, generator);
  F.row(2).setZero();
  F.col(2).setZero();
  F(2, 2) = 0.75;
  H.col(2).setZero();
  const RiccatiProblem problem{F, H, Matrix::Identity(3, 3), Matrix::Identity(4, 4)};
  const Matrix P0 = testing::random_psd(3, 3, generator);
  RiccatiMap map(problem);
  for (int k = 0; k < 5; ++k) {
    const Matrix P = testing::iterated(problem, P0, 1 << k);
    EXPECT_LT((map.after(P0) - P).norm(), 1e-13 * P.norm()) << k;
    ASSERT_TRUE(map.square());
  }
}

TEST(RiccatiMap, OfAModeThatGrowsKeepsItsDigits) {
  // f = 2, h² = q = ε: A passes 2^32 while 1 + ΘΓ passes 10^16. The limit is that of p² ε − p (3 + ε²) − ε =
  // 0.
  constexpr double kSmall = 1e-8;
  RiccatiMap map(scalar_problem(2.0, std::sqrt(kSmall), kSmall));
  for (int k = 0; k < 7; ++k) ASSERT_TRUE(map.square());
  EXPECT_NEAR(map.Theta()(0, 0) * kSmall / 3.0, 1.0, 1e-7);
}

TEST(RiccatiMap, IsLeftAsItWasWhereTheNextIsNotFinite) {
  RiccatiMap map(scalar_problem(1e60, 0, 1));
  ASSERT_TRUE(map.square());  // A = P = 1e120; squares of the next are beyond the range
  EXPECT_FALSE(map.square());
  EXPECT_EQ(map.doublings(), 1);
  EXPECT_NEAR(map.A()(0, 0), 1e120, 1e106);
  EXPECT_NEAR(map.after_centre()(0, 0), 1e120, 1e106);
}

TEST(RiccatiGrowth, HasTheExponentsOfItsTraces) {
  RiccatiGrowth growth;
  growth.traces = {10.0};
  EXPECT_EQ(growth.steps(), 1.0);
  EXPECT_EQ(growth.exponent(), 0.0);
  EXPECT_EQ(growth.trace_per_step(), 0.0);
  // Towards 11 as 1/k: increments of 0.5 and 0.25.
  growth.traces = {10.0, 10.5, 10.75};
  EXPECT_EQ(growth.steps(), 4.0);
  EXPECT_NEAR(growth.exponent(), std::log2(10.75 / 10.5), 1e-15);
  EXPECT_NEAR(growth.increment_exponent(), -1.0, 1e-15);
  EXPECT_NEAR(growth.trace_per_step(), 0.125, 1e-15);
  EXPECT_FALSE(growth.grows());
  // A walk of one per step beside something large: twice the increment, twice.
  growth.traces = {1001.0, 1002.0, 1004.0, 1008.0};
  EXPECT_NEAR(growth.increment_exponent(), 1.0, 1e-15);
  EXPECT_LT(growth.exponent(), 0.01);
  EXPECT_TRUE(growth.grows());
  growth.traces = {1001.0, 1002.0, 1004.0};  // once is not enough
  EXPECT_FALSE(growth.grows());
  growth.traces = {0.0, 0.0};
  EXPECT_EQ(growth.exponent(), 0.0);
  EXPECT_FALSE(growth.grows());
  growth.overflowed = true;
  EXPECT_TRUE(growth.grows());
  // Below 1e-5 of the trace an increment is rounding.
  growth.overflowed = false;
  growth.traces = {1e6, 1e6 + 1.0, 1e6 + 3.0, 1e6 + 7.0};
  EXPECT_EQ(growth.increment_exponent(), 0.0);
}

TEST(RiccatiGrowth, FollowsWalksAndPowers) {
  const RiccatiGrowth walk = riccati_growth(scalar_problem(1, 0, 0.5), testing::matrix_1x1(3.0), 6);
  ASSERT_EQ(walk.traces.size(), 7U);
  for (std::size_t k = 0; k < walk.traces.size(); ++k)
    EXPECT_NEAR(walk.traces[k], 3.0 + 0.5 * std::exp2(k), 1e-12) << k;
  EXPECT_NEAR(walk.trace_per_step(), 0.5, 1e-12);
  EXPECT_TRUE(walk.grows());
  EXPECT_FALSE(walk.overflowed);
  // 4^(2^k) passes 1e100 after 2^8 steps.
  const RiccatiGrowth power = riccati_growth(scalar_problem(2, 0, 0), testing::matrix_1x1(1.0));
  EXPECT_TRUE(power.overflowed);
  EXPECT_EQ(power.steps(), 128.0);
  EXPECT_NEAR(std::log2(power.P(0, 0)), 256.0, 1e-9);
}

}  // namespace
}  // namespace credence::internal
