#include "analysis/stability/riccati_newton.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::random_matrix;
using testing::random_psd;
using testing::scalar_problem;

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

LongMatrix in_long_double(const Matrix& M) { return M.cast<long double>(); }

/// One step from P, minus P, in long double.
LongMatrix long_defect(const RiccatiProblem& problem, const Matrix& P) {
  const LongMatrix F = in_long_double(problem.F), H = in_long_double(problem.H), X = in_long_double(P);
  const LongMatrix S = H * X * H.transpose() + in_long_double(problem.R);
  const LongMatrix update = X - X * H.transpose() * S.inverse() * H * X;
  return F * update * F.transpose() + in_long_double(problem.Qt) - X;
}

double long_residual(const RiccatiProblem& problem, const Matrix& P) {
  return static_cast<double>(long_defect(problem, P).norm() / in_long_double(P).norm());
}

/// Stabilisable and detectable, some with unstable modes.
RiccatiProblem regular_problem(Index n, double radius, unsigned seed) {
  std::mt19937_64 generator(seed);
  const Index m = std::max<Index>(1, n / 3);
  return {radius / std::sqrt(static_cast<double>(n)) * random_matrix(n, n, generator),
          random_matrix(m, n, generator), random_psd(n, m, generator) + 0.01 * Matrix::Identity(n, n),
          random_psd(m, m, generator) + Matrix::Identity(m, m)};
}

TEST(RiccatiResidual, IsThatOfLongDouble) {
  std::mt19937_64 generator(2);
  for (const Index n : {1, 3, 7}) {
    const RiccatiProblem problem = regular_problem(n, 1.2, 5);
    const Matrix P = random_psd(n, n, generator) + Matrix::Identity(n, n);
    const RiccatiResidual residual = riccati_residual(problem, P);
    const LongMatrix wanted = long_defect(problem, P);
    EXPECT_LT(static_cast<double>((in_long_double(residual.defect) - wanted).norm()), 1e-13 * P.norm());
    EXPECT_NEAR(residual.relative, long_residual(problem, P), 1e-13);
    const Matrix PHt = P * problem.H.transpose(), S = problem.H * PHt + problem.R;
    const Matrix closed = problem.F - problem.F * PHt * S.inverse() * problem.H;
    EXPECT_LT((residual.closed_loop - closed).norm(), 1e-12);
    EXPECT_EQ(residual.defect, residual.defect.transpose());
  }
}

TEST(RiccatiResidual, OfZeroIsRelativeToTheNoise) {
  // One step from 0 is Q_t.
  EXPECT_EQ(riccati_residual(scalar_problem(0.5, 1.0, 3.0), Matrix::Zero(1, 1)).relative, 1.0);
  EXPECT_EQ(riccati_residual(scalar_problem(0.5, 1.0, 0.0), Matrix::Zero(1, 1)).relative, 0.0);
}

TEST(RiccatiResidual, WithoutMeasurementsIsThatOfStein) {
  RiccatiProblem problem = scalar_problem(0.5, 1.0, 3.0);
  problem.H = Matrix(0, 1);
  problem.R = Matrix(0, 0);
  const RiccatiResidual residual = riccati_residual(problem, Matrix::Constant(1, 1, 2.0));
  EXPECT_EQ(residual.defect(0, 0), 0.25 * 2.0 + 3.0 - 2.0);
  EXPECT_EQ(residual.closed_loop(0, 0), 0.5);
  // Linear: one correction gives q/(1 − f²).
  Matrix P = Matrix::Constant(1, 1, 2.0);
  RiccatiResidual after;
  EXPECT_TRUE(newton_refine(problem, P, after));
  EXPECT_NEAR(P(0, 0), 4.0, 1e-14);
}

TEST(RiccatiRefinement, FindsTheGoldenRatio) {
  // P² = P + 1 for f = h = q = r = 1.
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  for (const double off : {1e-1, 1e-3, -1e-3, 1e-8}) {
    Matrix P = Matrix::Constant(1, 1, golden * (1.0 + off));
    RiccatiResidual residual;
    EXPECT_TRUE(newton_refine(scalar_problem(1, 1, 1), P, residual)) << off;
    EXPECT_NEAR(P(0, 0), golden, 1e-14) << off;
  }
}

TEST(RiccatiRefinement, ReachesTheDigitsOfDouble) {
  std::mt19937_64 generator(3);
  for (const Index n : {2, 6, 20}) {
    for (const double radius : {0.6, 1.3}) {
      const RiccatiProblem problem = regular_problem(n, radius, static_cast<unsigned>(10 + n));
      Matrix P = testing::iterated(problem, Matrix::Identity(n, n), 400);
      const Matrix nudge = random_psd(n, n, generator);
      P += 1e-5 * P.norm() / nudge.norm() * nudge;
      RiccatiResidual residual;
      ASSERT_TRUE(newton_refine(problem, P, residual)) << n << ", " << radius;
      EXPECT_LT(residual.relative, 1e-14);
      EXPECT_LT(long_residual(problem, P), 1e-14) << n << ", " << radius;
      const RiccatiResidual own = riccati_residual(problem, P);
      EXPECT_EQ(own.relative, residual.relative) << "that of the P returned";
      EXPECT_EQ(own.closed_loop, residual.closed_loop);
    }
  }
}

TEST(RiccatiRefinement, StopsAtItsTarget) {
  const RiccatiProblem problem = regular_problem(6, 0.9, 8);
  const Matrix best = testing::iterated(problem, Matrix::Identity(6, 6), 400);
  Matrix P = (1.0 + 1e-5) * best;
  RiccatiResidual residual;
  const double before = long_residual(problem, P);
  EXPECT_TRUE(newton_refine(problem, P, residual, 1e-8));
  EXPECT_LE(residual.relative, 1e-8);
  EXPECT_LT(residual.relative, before);
  EXPECT_GT(residual.relative, 1e-14) << "one correction is enough";
}

TEST(RiccatiRefinement, GivesNoCertificateWhereTheClosedLoopIsNotStable) {
  RiccatiResidual residual;
  Matrix P = Matrix::Zero(1, 1);
  EXPECT_FALSE(newton_refine(scalar_problem(2, 1, 0), P, residual)) << "a fixed point that is unstable";
  EXPECT_EQ(residual.relative, 0.0);
  EXPECT_EQ(P(0, 0), 0.0);
  EXPECT_FALSE(newton_refine(scalar_problem(1, 1, 0), P, residual)) << "a constant: 1 on the unit circle";
  P = Matrix::Constant(1, 1, 5.0);
  EXPECT_FALSE(newton_refine(scalar_problem(1, 0, 0), P, residual)) << "nothing sees it";
  EXPECT_EQ(P(0, 0), 5.0);
  P(0, 0) = std::nan("");
  EXPECT_FALSE(newton_refine(scalar_problem(0.5, 1, 1), P, residual));
}

TEST(RiccatiRefinement, StandsANearlyUnstableLoop) {
  // q = ε² with f = h = r = 1: P = ε²/2 + ε √(1 + ε²/4), closed loop about 1 − ε.
  constexpr double kSmall = 1e-4;
  const double exact = 0.5 * kSmall * kSmall + kSmall * std::sqrt(1.0 + 0.25 * kSmall * kSmall);
  Matrix P = Matrix::Constant(1, 1, 1.001 * exact);
  RiccatiResidual residual;
  EXPECT_TRUE(newton_refine(scalar_problem(1, 1, kSmall * kSmall), P, residual));
  EXPECT_NEAR(P(0, 0) / exact, 1.0, 1e-10);
}

}  // namespace
}  // namespace credence::internal
