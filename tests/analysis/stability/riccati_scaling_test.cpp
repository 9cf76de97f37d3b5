#include "analysis/stability/riccati_scaling.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::random_matrix;
using testing::random_psd;

RiccatiProblem unscaled_problem(Index n, Index m, unsigned seed) {
  std::mt19937_64 generator(seed);
  return {random_matrix(n, n, generator), random_matrix(m, n, generator), random_psd(n, n, generator),
          random_psd(m, m, generator) + Matrix::Identity(m, m)};
}

/// In states of other units, x' = units · x.
RiccatiProblem in_units(const RiccatiProblem& problem, const Vector& units) {
  const Vector inverse = units.cwiseInverse();
  return {units.asDiagonal() * problem.F * inverse.asDiagonal(), problem.H * inverse.asDiagonal(),
          units.asDiagonal() * problem.Qt * units.asDiagonal(), problem.R};
}

const Vector kOddUnits{{1e6, 1e-7, 1.0, 1e3, 3e-2}};

TEST(RiccatiScaling, ChangesUnitsByPowersOfTwo) {
  const RiccatiProblem problem = in_units(unscaled_problem(5, 2, 1), kOddUnits);
  std::mt19937_64 generator(2);
  const Matrix P0 = random_psd(5, 5, generator);
  const ScaledRiccati scaled = scale_riccati(problem, P0);
  ASSERT_EQ(scaled.d.size(), 5);
  for (const double d : scaled.d) {
    int exponent = 0;
    EXPECT_EQ(std::frexp(d, &exponent), 0.5) << d;
  }
  // Nothing is rounded: the old matrices come back bit for bit.
  const auto D = scaled.d.asDiagonal();
  const Vector inverse = scaled.d.cwiseInverse();
  EXPECT_EQ(Matrix(D * scaled.problem.F * inverse.asDiagonal()), problem.F);
  EXPECT_EQ(scaled.unscaled(scaled.problem.Qt), problem.Qt);
  EXPECT_EQ(scaled.unscaled(scaled.P0), P0);
}

TEST(RiccatiScaling, WhitensTheMeasurements) {
  const RiccatiProblem problem = unscaled_problem(4, 3, 3);
  const ScaledRiccati scaled = scale_riccati(problem, Matrix::Identity(4, 4));
  EXPECT_EQ(scaled.problem.R, Matrix::Identity(3, 3));
  const Matrix back = scaled.problem.H * scaled.d.cwiseInverse().asDiagonal();
  const Matrix information = problem.H.transpose() * problem.R.llt().solve(problem.H);
  EXPECT_LT((back.transpose() * back - information).norm(), 1e-13 * information.norm());
}

TEST(RiccatiScaling, IsTheSameFilter) {
  for (const Index m : {1, 2, 0}) {
    RiccatiProblem problem = unscaled_problem(5, std::max<Index>(m, 1), 4);
    if (m == 0) {
      problem.H = Matrix(0, 5);
      problem.R = Matrix(0, 0);
    }
    problem = in_units(problem, kOddUnits);
    std::mt19937_64 generator(5);
    const Matrix P0 = kOddUnits.asDiagonal() * random_psd(5, 5, generator) * kOddUnits.asDiagonal();
    const ScaledRiccati scaled = scale_riccati(problem, P0);
    const Matrix plain = riccati_step(problem, P0);
    const Matrix back = scaled.unscaled(riccati_step(scaled.problem, scaled.P0));
    const Vector unit = plain.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT((unit.asDiagonal() * (back - plain) * unit.asDiagonal()).norm(), 1e-10) << m;
  }
}

/// The largest ratio of the rows of F and Q_t to the columns of F and Hᵀ R⁻¹ H, either way, the diagonal of F
/// apart.
double worst_imbalance(const RiccatiProblem& problem) {
  const Matrix Gamma = problem.H.transpose() * problem.R.llt().solve(problem.H);
  double worst = 1.0;
  for (Index i = 0; i < problem.F.rows(); ++i) {
    const double own = std::abs(problem.F(i, i));
    const double row = problem.F.row(i).cwiseAbs().sum() - own + problem.Qt.col(i).cwiseAbs().sum();
    const double column = problem.F.col(i).cwiseAbs().sum() - own + Gamma.col(i).cwiseAbs().sum();
    worst = std::max({worst, row / column, column / row});
  }
  return worst;
}

TEST(RiccatiScaling, BalancesTheTwoHalvesOfThePencil) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RiccatiProblem problem = in_units(unscaled_problem(5, 2, 20 + seed), kOddUnits);
    const ScaledRiccati scaled = scale_riccati(problem, Matrix::Identity(5, 5));
    EXPECT_GT(worst_imbalance(problem), 1e6);
    // A step of less than a factor of four is not made: it would change a ratio by 2^(4 · 1.5) at most.
    EXPECT_LT(worst_imbalance(scaled.problem), 64.0) << seed;
  }
}

TEST(RiccatiScaling, LeavesAStateThatNothingSizes) {
  // No noise and no initial variance, or not seen.
  EXPECT_EQ(scale_riccati(testing::scalar_problem(1, 1, 0), Matrix::Zero(1, 1)).d[0], 1.0);
  EXPECT_EQ(scale_riccati(testing::scalar_problem(1, 0, 1e9), Matrix::Zero(1, 1)).d[0], 1.0);
}

TEST(RiccatiScaling, StaysWithinTheRangeOfDouble) {
  const ScaledRiccati scaled = scale_riccati(testing::scalar_problem(1, 1e-140, 1e300), Matrix::Ones(1, 1));
  EXPECT_EQ(scaled.d[0], std::exp2(120.0));
  EXPECT_TRUE(scaled.problem.Qt.allFinite() && scaled.P0.allFinite());
  EXPECT_GT(scaled.P0(0, 0), 0.0);
}

TEST(RiccatiScaling, SizesWhatNoNoiseDrivesByItsStart) {
  const RiccatiProblem constant = testing::scalar_problem(1, 1, 0);
  const ScaledRiccati scaled = scale_riccati(constant, Matrix::Constant(1, 1, std::exp2(20.0)));
  EXPECT_EQ(scaled.d[0], std::exp2(5.0));  // row 2^(20 − 2 e) = column 2^(2 e)
}

}  // namespace
}  // namespace credence::internal
