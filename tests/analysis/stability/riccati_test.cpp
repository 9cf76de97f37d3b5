#include "analysis/stability/riccati.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "analysis/stability/riccati_newton.h"
#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::iterated;
using testing::plain_residual;
using testing::random_matrix;
using testing::random_psd;
using testing::read_golden_problem;
using testing::riccati_problem;
using testing::scalar_problem;

double smallest_eigenvalue(const Matrix& P) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(P, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
}

double relative_difference(const Matrix& A, const Matrix& B) { return (A - B).norm() / B.norm(); }

void expect_golden(const char* name, double trace, double spectral_radius) {
  const RiccatiProblem problem = read_golden_problem(name);
  const RiccatiSolution solution = solve_riccati(problem);
  EXPECT_EQ(solution.kind, RiccatiKind::stabilising);
  EXPECT_NEAR(solution.P.trace() / trace, 1.0, 1e-10);
  EXPECT_LT(solution.residual, 1e-13);
  EXPECT_LT(plain_residual(problem, solution.P), 1e-13);
  EXPECT_NEAR(solution.spectral_radius, spectral_radius, 5e-4);
}

// Traces and radii: README of the golden values, three and more digits.
TEST(RiccatiGolden, TenStates) { expect_golden("dare_n10.txt", 31.7474406657, 0.746); }
TEST(RiccatiGolden, FiftyStates) { expect_golden("dare_n50.txt", 697.487609385, 0.952); }

TEST(RiccatiStep, ByHand) {
  // P = 1: posterior 1 − 1·1/2 = 1/2, prior 2·½·2 + 1 = 3.
  EXPECT_DOUBLE_EQ(riccati_step(scalar_problem(2, 1, 1), Matrix::Ones(1, 1))(0, 0), 3.0);
}

struct ScalarCase {
  double f, h, q, p0;
  RiccatiKind kind;
  double limit;            // of the prior
  double spectral_radius;  // of f − f k h
};

// Closed forms of the scalar equation, R = 1: p² h² + p (1 − f² − q h²) − q = 0.
TEST(RiccatiKinds, ScalarsWithClosedForms) {
  const double kGolden = 0.5 * (1.0 + std::sqrt(5.0));
  const ScalarCase cases[] = {
      {1, 1, 1, 1, RiccatiKind::stabilising, kGolden, 1 / (1 + kGolden)},
      {2, 1, 0, 1, RiccatiKind::stabilising, 3.0, 0.5},         // unstable, no noise touches it
      {2, 1, 0, 0, RiccatiKind::depends_on_initial, 0.0, 2.0},  // and P0 leaves it out
      {1, 1, 0, 1, RiccatiKind::strong, 0.0, 1.0},              // a constant is learnt perfectly, as 1/k
      {-1, 1, 0, 1, RiccatiKind::strong, 0.0, 1.0},
      {1, 0, 0, 7, RiccatiKind::depends_on_initial, 7.0, 1.0},   // a constant that nothing observes
      {0.5, 0, 1, 1, RiccatiKind::stabilising, 4.0 / 3.0, 0.5},  // unobserved, but it forgets
      {0, 1, 0, 1, RiccatiKind::stabilising, 0.0, 0.0},
      {0.5, 1, 0, 1, RiccatiKind::stabilising, 0.0, 0.5},
      {1, 1, 1e-14, 1, RiccatiKind::stabilising, 0.5 * (1e-14 + std::sqrt(1e-28 + 4e-14)), 0.9999999},
      {1 + 1e-6, 1, 0, 1, RiccatiKind::stabilising, (1 + 1e-6) * (1 + 1e-6) - 1, 1 / (1 + 1e-6)},
      {2, 1e-8, 1e-8, 1, RiccatiKind::stabilising, 3e16, 0.5},
  };
  for (const ScalarCase& c : cases) {
    const RiccatiSolution solution = solve_riccati(scalar_problem(c.f, c.h, c.q), testing::matrix_1x1(c.p0));
    SCOPED_TRACE(::testing::Message() << "f " << c.f << " h " << c.h << " q " << c.q << " p0 " << c.p0);
    EXPECT_EQ(to_string(solution.kind), to_string(c.kind)) << solution.reason;
    EXPECT_NEAR(solution.P(0, 0), c.limit, 1e-9 * c.limit);
    EXPECT_NEAR(solution.spectral_radius, c.spectral_radius, 1e-9);
    EXPECT_TRUE(solution.stays_bounded && solution.has_limit());
  }
}

TEST(RiccatiKinds, ARandomWalkThatNobodySeesGrowsLinearly) {
  const RiccatiSolution solution = solve_riccati(scalar_problem(1, 0, 0.5), Matrix::Ones(1, 1));
  EXPECT_EQ(solution.kind, RiccatiKind::unbounded);
  EXPECT_EQ(to_string(solution.kind), "none");
  EXPECT_NEAR(solution.growth_exponent, 1.0, 1e-5);
  EXPECT_FALSE(solution.exponential);
  EXPECT_NEAR(solution.P(0, 0), 1.0 + 0.5 * solution.steps, 1e-6 * solution.steps);
}

TEST(RiccatiKinds, AnUnstableModeThatNobodySeesGrowsExponentially) {
  const RiccatiSolution solution = solve_riccati(scalar_problem(1.5, 0, 0), Matrix::Ones(1, 1));
  EXPECT_EQ(solution.kind, RiccatiKind::unbounded);
  EXPECT_TRUE(solution.exponential);
  // Mixed with a state that is seen, so that rounding ends the recursion long before 1e100.
  const Matrix turn{{0.8, -0.6}, {0.6, 0.8}};
  const Matrix modes = Vector{{0.9, 1.02}}.asDiagonal();
  const RiccatiProblem mixed{turn * modes * turn.transpose(), Matrix{{1.0, 0.0}} * turn.transpose(),
                             0.1 * Matrix::Identity(2, 2), Matrix::Ones(1, 1)};
  const RiccatiSolution early = solve_riccati(mixed, Matrix::Identity(2, 2));
  EXPECT_EQ(early.kind, RiccatiKind::unbounded);
  EXPECT_LT(early.P.trace(), 1e50);
  EXPECT_TRUE(early.exponential);
  EXPECT_GT(solution.growth_exponent, 10.0);
  EXPECT_TRUE(solution.P.allFinite());
}

/// Constant velocity, F = [1 1; 0 1]: a Jordan block on the unit circle.
RiccatiProblem constant_velocity(double h_position, double h_velocity, double velocity_noise) {
  RiccatiProblem problem;
  problem.F = Matrix::Identity(2, 2);
  problem.F(0, 1) = 1.0;
  problem.H = Matrix(1, 2);
  problem.H << h_position, h_velocity;
  problem.Qt = Matrix::Zero(2, 2);
  problem.Qt(1, 1) = velocity_noise;
  problem.R = Matrix::Ones(1, 1);
  return problem;
}

TEST(RiccatiKinds, DefectiveModes) {
  const Matrix I = Matrix::Identity(2, 2);
  EXPECT_EQ(solve_riccati(constant_velocity(1, 0, 1), I).kind, RiccatiKind::stabilising);

  const RiccatiSolution learnt = solve_riccati(constant_velocity(1, 0, 0), I);
  EXPECT_EQ(learnt.kind, RiccatiKind::strong) << learnt.reason;
  EXPECT_LT(learnt.P.norm(), 1e-12);

  // A velocity seen without noise in it is learnt as 1/k; the sum of its errors is a random walk.
  const RiccatiSolution drift = solve_riccati(constant_velocity(0, 1, 0), I);
  EXPECT_EQ(drift.kind, RiccatiKind::unbounded) << drift.reason;
  EXPECT_NEAR(drift.growth_exponent, 1.0, 1e-3);

  // An integrated random walk that nothing observes: variance ~ k³ / 3.
  const RiccatiSolution blind = solve_riccati(constant_velocity(0, 0, 1), I);
  EXPECT_EQ(blind.kind, RiccatiKind::unbounded);
  EXPECT_NEAR(blind.growth_exponent, 3.0, 1e-3);

  // A Jordan chain of three on the unit circle, in other coordinates: its eigenvalues scatter by 1e-5.
  std::mt19937_64 generator(3);
  RiccatiProblem chain;
  const Matrix T = random_matrix(3, 3, generator) + 3.0 * Matrix::Identity(3, 3);
  Matrix J = Matrix::Identity(3, 3);
  J(0, 1) = J(1, 2) = 1.0;
  chain.F = T * J * T.inverse();
  chain.H = Matrix::Identity(1, 3) * T.inverse();
  chain.Qt = Matrix::Zero(3, 3);
  chain.R = Matrix::Ones(1, 1);
  const RiccatiSolution third = solve_riccati(chain, Matrix::Identity(3, 3));
  EXPECT_EQ(third.kind, RiccatiKind::strong) << third.reason;
}

TEST(RiccatiKinds, UnstabilisableAndUndetectableParts) {
  // diag(2 without noise, ½ with): stabilisable by P0 only. diag(2 unseen, ½): unbounded unless P0 is 0
  // there.
  RiccatiProblem problem;
  problem.F = Eigen::Vector2d(2.0, 0.5).asDiagonal();
  problem.Qt = Eigen::Vector2d(0.0, 1.0).asDiagonal();
  problem.R = Matrix::Ones(1, 1);
  problem.H = Matrix::Ones(1, 2);
  const RiccatiSolution seen = solve_riccati(problem, Matrix::Identity(2, 2));
  EXPECT_EQ(seen.kind, RiccatiKind::stabilising) << seen.reason;
  EXPECT_LT(relative_difference(seen.P, iterated(problem, Matrix::Identity(2, 2), 200)), 1e-12);

  problem.H << 0.0, 1.0;
  EXPECT_EQ(solve_riccati(problem, Matrix::Identity(2, 2)).kind, RiccatiKind::unbounded);
  const Matrix P0 = Eigen::Vector2d(0.0, 1.0).asDiagonal();
  const RiccatiSolution left_out = solve_riccati(problem, P0);
  EXPECT_EQ(left_out.kind, RiccatiKind::depends_on_initial) << left_out.reason;
  EXPECT_LT(relative_difference(left_out.P, iterated(problem, P0, 200)), 1e-12);
}

TEST(RiccatiKinds, NoMeasurementAtAll) {
  RiccatiProblem problem{0.5 * Matrix::Identity(3, 3), Matrix(0, 3), Matrix::Identity(3, 3), Matrix(0, 0)};
  EXPECT_EQ(solve_riccati(problem).kind, RiccatiKind::stabilising);
  EXPECT_NEAR(solve_riccati(problem).P.trace(), 4.0, 1e-12);
  problem.F.setIdentity();
  EXPECT_EQ(solve_riccati(problem).kind, RiccatiKind::unbounded);
}

TEST(RiccatiDoubling, EqualsPlainIteration) {
  std::mt19937_64 generator(11);
  for (int round = 0; round < 30; ++round) {
    const Index n = 1 + round % 6, m = 1 + round % 3;
    RiccatiProblem problem{random_matrix(n, n, generator) / std::sqrt(static_cast<double>(n)),
                           random_matrix(m, n, generator), random_psd(n, round % (n + 1), generator),
                           random_psd(m, m, generator) + Matrix::Identity(m, m)};
    if (round % 4 == 3) problem.H.col(0).setZero();
    const Matrix P0 = random_psd(n, round % (n + 1), generator);
    RiccatiMap around_zero(problem), around_start(problem, P0);
    Matrix P = riccati_step(problem, P0);
    for (int k = 0; k < 6; ++k) {
      const double size = 1.0 + P.norm();
      EXPECT_LT((around_zero.after(P0) - P).norm(), 1e-9 * size) << "round " << round << " 2^" << k;
      EXPECT_LT((around_start.after_centre() - P).norm(), 1e-9 * size) << "round " << round << " 2^" << k;
      P = iterated(problem, P, 1 << k);
      ASSERT_TRUE(around_zero.square() && around_start.square());
    }
  }
}

void expect_stabilising(const RiccatiProblem& problem, double tolerance, int plain_steps) {
  const Index n = problem.state_dim();
  const Matrix I = Matrix::Identity(n, n);
  const RiccatiSolution solution = solve_riccati(problem, I);
  ASSERT_EQ(solution.kind, RiccatiKind::stabilising) << solution.reason;
  EXPECT_LE(solution.residual, 1e-14);
  EXPECT_LT(plain_residual(problem, solution.P), 1e-14);
  EXPECT_LT(solution.spectral_radius, 1.0);
  EXPECT_NEAR(solution.growth_exponent, 0.0, 1e-3);
  EXPECT_LT(relative_difference(solution.P, iterated(problem, I, plain_steps)), tolerance);
}

TEST(RiccatiRegular, RandomStabilisableDetectableSystems) {
  std::mt19937_64 generator(5);
  for (const Index n : {2, 5, 10, 20, 40}) {
    for (const double radius : {0.7, 1.1}) {  // of F: stable, and with unstable modes
      const Index m = std::max<Index>(1, n / 4);
      const RiccatiProblem problem{
          radius / std::sqrt(static_cast<double>(n)) * random_matrix(n, n, generator),
          random_matrix(m, n, generator), random_psd(n, m, generator), Matrix::Identity(m, m)};
      SCOPED_TRACE(::testing::Message() << "n " << n << " radius " << radius);
      expect_stabilising(problem, 1e-11, 600);
    }
  }
}

TEST(RiccatiRegular, RandomSystemOf200States) {
  std::mt19937_64 generator(6);
  const Index n = 200, m = 20;
  const RiccatiProblem problem{0.3 / std::sqrt(static_cast<double>(n)) * random_matrix(n, n, generator),
                               random_matrix(m, n, generator), random_psd(n, m, generator),
                               Matrix::Identity(m, m)};
  // As many noises as measurements draw the closed loop to the zeros between them, here to a radius of 0.84.
  expect_stabilising(problem, 1e-12, 100);
}

TEST(RiccatiRegular, DoesNotDependOnTheInitialCovariance) {
  std::mt19937_64 generator(8);
  const RiccatiProblem problem{0.4 * random_matrix(6, 6, generator), random_matrix(2, 6, generator),
                               random_psd(6, 2, generator), Matrix::Identity(2, 2)};
  const RiccatiSolution one = solve_riccati(problem, Matrix::Zero(6, 6));
  const RiccatiSolution two = solve_riccati(problem, 1e6 * random_psd(6, 3, generator));
  EXPECT_LT(relative_difference(one.P, two.P), 1e-13);
}

TEST(RiccatiNewton, RefinesAndCertifies) {
  std::mt19937_64 generator(9);
  const RiccatiProblem problem{0.4 * random_matrix(6, 6, generator), random_matrix(2, 6, generator),
                               random_psd(6, 2, generator), Matrix::Identity(2, 2)};
  Matrix P = solve_riccati(problem).P * (1.0 + 1e-4);
  RiccatiResidual residual;
  EXPECT_TRUE(newton_refine(problem, P, residual));
  EXPECT_LT(residual.relative, 1e-14);
  EXPECT_LT(relative_difference(P, solve_riccati(problem).P), 1e-12);
  Matrix zero = Matrix::Zero(1, 1);  // a fixed point, and not the stabilising one
  EXPECT_FALSE(newton_refine(scalar_problem(2, 1, 0), zero, residual));
}

/// The limit of a monobot whose differences of landmarks are known: two states, the vehicle and the common
/// position of the map, seen with the variance R/N; plain iteration in long double.
struct TwoStateLimit {
  double vehicle, landmark, cross;
};

TwoStateLimit two_state_limit(long double vehicle0, const Vector& landmarks0, long double q, long double r) {
  long double information = 0.0L;
  for (const double variance : landmarks0) information += 1.0L / static_cast<long double>(variance);
  const long double r_mean = r / static_cast<long double>(landmarks0.size());
  long double rr = vehicle0, rf = 0.0L, ff = 1.0L / information;
  for (int k = 0; k < 4000; ++k) {
    const long double s = rr - 2.0L * rf + ff + r_mean;  // z = f − r
    const long double r_row = rf - rr, f_row = ff - rf;
    rr = rr - r_row * r_row / s + q;
    ff = ff - f_row * f_row / s;
    rf = rf - r_row * f_row / s;
  }
  return {static_cast<double>(rr), static_cast<double>(ff), static_cast<double>(rf)};
}

void expect_monobot_limit(const RiccatiSolution& solution, const TwoStateLimit& limit, double tolerance) {
  const Index N = solution.P.rows() - 1;
  EXPECT_EQ(solution.kind, RiccatiKind::depends_on_initial) << solution.reason;
  EXPECT_NEAR(solution.P(0, 0), limit.vehicle, tolerance);
  const auto map = solution.P.bottomRightCorner(N, N).array();
  EXPECT_LT((map - limit.landmark).abs().maxCoeff(), tolerance);
  EXPECT_LT((solution.P.row(0).tail(N).array() - limit.cross).abs().maxCoeff(), tolerance);
  EXPECT_NEAR(solution.spectral_radius, 1.0, 1e-10);
}

TEST(RiccatiMarginal, FourLandmarksOfTheory) {
  const LinearModel model = monobot_model(4, 0, 0.1, 0.1, 1.0);
  Vector variances(5);
  variances << 0.3, 1.0, 2.0, 0.5, 0.7;
  const RiccatiSolution solution = solve_riccati(riccati_problem(model), Matrix(variances.asDiagonal()));
  const TwoStateLimit limit = two_state_limit(0.3L, variances.tail(4), 0.1L, 0.1L);
  EXPECT_NEAR(limit.vehicle, 0.244986, 5e-7);     // theory, section 3
  EXPECT_NEAR(limit.landmark, 0.12427537, 5e-9);  // theory, section 3
  expect_monobot_limit(solution, limit, 1e-12);
}

TEST(RiccatiMarginal, MonobotsFrom1To200Landmarks) {
  for (const Index N : {1, 2, 3, 5, 8, 20, 60, 200}) {
    SCOPED_TRACE(::testing::Message() << N << " landmarks");
    const LinearModel model = monobot_model(N, 0, 0.1, 0.1, 1.0);
    const RiccatiOptions options{.closed_loop_eigenvalues = true};
    const RiccatiSolution solution = solve_riccati(riccati_problem(model), model.P0, options);
    expect_monobot_limit(solution, two_state_limit(1.0L, Vector::Ones(N), 0.1L, 0.1L), 1e-11);
    EXPECT_LT(solution.residual, 1e-12);
  }
}

TEST(RiccatiMarginal, PlainIterationGoesToTheLimitAsOneOverK) {
  for (const Index N : {1, 2, 4, 7}) {
    const LinearModel model = monobot_model(N, 0, 0.1, 0.1, 1.0);
    const RiccatiProblem problem = riccati_problem(model);
    const Matrix early = iterated(problem, model.P0, 2000);
    const Matrix late = iterated(problem, early, 2000);
    const Matrix extrapolated = 2.0 * late - early;
    EXPECT_LT(relative_difference(solve_riccati(problem, model.P0).P, extrapolated), 1e-6) << N;
  }
}

TEST(RiccatiMarginal, AnchoredStaticMapIsLearntWhateverP0) {
  for (const Index N : {1, 3, 40}) {
    const LinearModel model = monobot_model(N, 1, 0.1, 0.1, 1.0);
    const RiccatiSolution solution = solve_riccati(riccati_problem(model), model.P0);
    const RiccatiSolution other = solve_riccati(riccati_problem(model), 100.0 * model.P0);
    EXPECT_EQ(solution.kind, RiccatiKind::strong) << solution.reason;
    EXPECT_LT(relative_difference(other.P, solution.P), 1e-12);
    EXPECT_LT(solution.P.bottomRightCorner(N, N).norm(), 1e-12);
    // The vehicle against N + 1 known landmarks: p² = q p + q r/(N + 1).
    const double r = 0.1 / static_cast<double>(N + 1);
    EXPECT_NEAR(solution.P(0, 0), 0.5 * (0.1 + std::sqrt(0.01 + 0.4 * r)), 1e-12);
  }
}

TEST(RiccatiMarginal, EigenvaluesOfOneLandmarkAreOneAndROverS) {
  const LinearModel model = monobot_model(1, 0, 0.3, 0.2, 1.0);
  const RiccatiSolution solution = solve_riccati(riccati_problem(model), model.P0);
  const double s = (model.H * solution.P * model.H.transpose() + model.R)(0, 0);
  ASSERT_EQ(solution.closed_loop_eigenvalues.size(), 2);
  EXPECT_NEAR(std::abs(solution.closed_loop_eigenvalues[0] - 1.0), 0.0, 1e-13);  // eq. (14), corrected
  EXPECT_NEAR(std::abs(solution.closed_loop_eigenvalues[1] - 0.2 / s), 0.0, 1e-13);
}

TEST(RiccatiMarginal, SingularInitialCovariance) {
  // A map known exactly: only the vehicle walks. Another P0 has another limit.
  const LinearModel model = monobot_model(3, 0, 0.1, 0.1, 1.0);
  Matrix P0 = Matrix::Zero(4, 4);
  P0(0, 0) = 1.0;
  const RiccatiSolution solution = solve_riccati(riccati_problem(model), P0);
  EXPECT_EQ(solution.kind, RiccatiKind::depends_on_initial) << solution.reason;
  EXPECT_LT(relative_difference(solution.P, iterated(riccati_problem(model), P0, 300)), 1e-12);
  EXPECT_EQ(solution.P.bottomRightCorner(3, 3).norm(), 0.0);
}

TEST(RiccatiMarginal, RotatingModesThatNothingTouches) {
  // An unobserved rotation of eigenvalues e^{±i}, and an observed one that is learnt.
  const auto rotation = [](double angle) {
    return Eigen::Matrix2d(Eigen::Rotation2Dd(angle).toRotationMatrix());
  };
  RiccatiProblem problem;
  problem.F = Matrix::Zero(5, 5);
  problem.F.topLeftCorner(2, 2) = rotation(1.0);
  problem.F.block(2, 2, 2, 2) = rotation(0.5);
  problem.F(4, 4) = 0.9;
  problem.H = Matrix::Zero(1, 5);
  problem.H(0, 2) = problem.H(0, 4) = 1.0;
  problem.Qt = Matrix::Zero(5, 5);
  problem.Qt(4, 4) = 0.1;
  problem.R = Matrix::Ones(1, 1);
  const RiccatiSolution solution = solve_riccati(problem, Matrix::Identity(5, 5));
  EXPECT_EQ(solution.kind, RiccatiKind::depends_on_initial) << solution.reason;
  EXPECT_LT((solution.P.topLeftCorner(2, 2) - Matrix::Identity(2, 2)).norm(), 1e-10);
  EXPECT_LT(solution.P.block(2, 2, 2, 2).norm(), 1e-10);
}

TEST(RiccatiHostile, UnitsDoNotMatter) {
  std::mt19937_64 generator(21);
  for (int round = 0; round < 12; ++round) {
    const Index n = 4, m = 2;
    RiccatiProblem problem{0.5 * random_matrix(n, n, generator), random_matrix(m, n, generator),
                           random_psd(n, 1, generator), Matrix::Identity(m, m)};
    if (round % 3 == 1) problem = riccati_problem(monobot_model(3, 0, 0.1, 0.1, 1.0));
    if (round % 3 == 2) problem = riccati_problem(monobot_model(3, 1, 0.1, 0.1, 1.0));
    Vector d(n);
    for (Index i = 0; i < n; ++i)
      d[i] = std::pow(10.0, 3.0 * std::sin(static_cast<double>(7 * round + 3 * i)));
    const Vector inverse = d.cwiseInverse();
    const RiccatiProblem rescaled{d.asDiagonal() * problem.F * inverse.asDiagonal(),
                                  problem.H * inverse.asDiagonal(),
                                  d.asDiagonal() * problem.Qt * d.asDiagonal(), problem.R};
    const Matrix P0 = Matrix::Identity(n, n);
    const RiccatiSolution one = solve_riccati(problem, P0);
    const RiccatiSolution two = solve_riccati(rescaled, d.asDiagonal() * P0 * d.asDiagonal());
    EXPECT_EQ(to_string(one.kind), to_string(two.kind)) << round << ": " << one.reason << two.reason;
    EXPECT_LT(relative_difference(inverse.asDiagonal() * two.P * inverse.asDiagonal(), one.P), 1e-9) << round;
  }
}

/// Small systems with every kind of defect: modes inside, on, outside the circle, chains, blind sensors,
/// missing noise, singular P0.
RiccatiProblem hostile_problem(Index n, std::mt19937_64& generator, Matrix& P0) {
  std::uniform_int_distribution<int> pick(0, 5);
  const double moduli[] = {0.0, 0.5, 1.0, 1.0, -1.0, 1.5};
  Matrix J = Matrix::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    J(i, i) = moduli[pick(generator)];
    if (i > 0 && J(i, i) == J(i - 1, i - 1) && pick(generator) == 0) J(i - 1, i) = 1.0;
  }
  Matrix H = Matrix::Ones(1, n), Q = Matrix::Zero(n, n);
  P0 = Matrix::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    H(0, i) = pick(generator) < 2 ? 0.0 : 1.0;
    Q(i, i) = pick(generator) < 3 ? 0.0 : 1.0;
    P0(i, i) = pick(generator) == 0 ? 0.0 : 1.0;
  }
  const Matrix T = Matrix::Identity(n, n) + 0.3 * random_matrix(n, n, generator);
  const Matrix T_inverse = T.inverse();
  P0 = (T * P0 * T.transpose()).eval();
  return {T * J * T_inverse, H * T_inverse, T * Q * T.transpose(), Matrix::Ones(1, 1)};
}

TEST(RiccatiHostile, EveryDefectHasANamedOutcome) {
  std::mt19937_64 generator(31);
  int undecided = 0, counts[6] = {};
  constexpr int kRounds = 400;
  for (int round = 0; round < kRounds; ++round) {
    Matrix P0;
    const RiccatiProblem problem = hostile_problem(1 + round % 5, generator, P0);
    const RiccatiSolution solution = solve_riccati(problem, P0);
    ++counts[static_cast<int>(solution.kind)];
    ASSERT_TRUE(solution.P.allFinite()) << round;
    ASSERT_TRUE(solution.K.allFinite()) << round;
    if (solution.kind == RiccatiKind::undecided) {
      ++undecided;
      EXPECT_FALSE(solution.reason.empty()) << round;
      continue;
    }
    if (solution.kind == RiccatiKind::oscillating) {
      EXPECT_TRUE(solution.stays_bounded) << round;
      continue;
    }
    if (!solution.has_limit()) {
      EXPECT_GT(solution.growth_exponent, 0.5) << round;
      continue;
    }
    EXPECT_GE(smallest_eigenvalue(solution.P), -1e-9 * (1.0 + solution.P.norm())) << round;
    EXPECT_LT(plain_residual(problem, solution.P), 1e-7) << round << " " << to_string(solution.kind);
    // Where P0 leaves out an unstable mode, plain iteration leaves the limit by its own rounding.
    if (solution.spectral_radius > 1.0 + 1e-6) continue;
    // Static states fall as 1/k: 3000 plain steps are within a per cent or so of any limit.
    const Matrix plain = iterated(problem, P0, 3000);
    EXPECT_LT((solution.P - plain).norm(), 0.02 * (1.0 + plain.norm()))
        << round << " " << to_string(solution.kind);
  }
  for (const int kind : {0, 1, 2, 4}) EXPECT_GT(counts[kind], kRounds / 50) << "kind " << kind;
  EXPECT_LE(undecided, kRounds / 20);
}

TEST(RiccatiInput, BadInputIsNamed) {
  const RiccatiProblem good = scalar_problem(1, 1, 1);
  const Matrix P0 = Matrix::Ones(1, 1);
  const auto message_of = [&](const RiccatiProblem& problem, const Matrix& start) -> std::string {
    try {
      solve_riccati(problem, start);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message_of(good, P0), "");
  RiccatiProblem bad = good;
  bad.H = Matrix::Ones(1, 2);
  EXPECT_THAT(message_of(bad, P0), ::testing::HasSubstr("H is 1x2"));
  bad = good;
  bad.F(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of(bad, P0), ::testing::HasSubstr("F has an entry that is not finite"));
  bad = good;
  bad.R(0, 0) = 0.0;
  EXPECT_THAT(message_of(bad, P0), ::testing::HasSubstr("R is not positive definite"));
  bad = good;
  bad.Qt(0, 0) = -1.0;
  EXPECT_THAT(message_of(bad, P0), ::testing::HasSubstr("Qt is not positive semidefinite"));
  EXPECT_THAT(message_of(good, -P0), ::testing::HasSubstr("P0 is not positive semidefinite"));
  RiccatiProblem two{Matrix::Identity(2, 2), Matrix::Identity(2, 2), Matrix::Identity(2, 2),
                     Matrix::Identity(2, 2)};
  two.Qt(0, 1) = 0.5;
  EXPECT_THAT(message_of(two, Matrix::Identity(2, 2)), ::testing::HasSubstr("Qt is not symmetric"));
}

TEST(RiccatiHostile, TwoStatesApartKeepTheirOwnDigits) {
  for (const double unit : {1e4, 1e8}) {
    for (const double q : {1e-4, 1e-8}) {
      const RiccatiProblem problem{Vector{{0.5, 1.0}}.asDiagonal(), Matrix::Identity(2, 2),
                                   Vector{{unit, q / unit}}.asDiagonal(),
                                   Vector{{unit, 1.0 / unit}}.asDiagonal()};
      const RiccatiSolution solution = solve_riccati(problem, problem.Qt);
      EXPECT_EQ(solution.kind, RiccatiKind::stabilising);
      // p² = q (p + 1).
      EXPECT_NEAR(solution.P(1, 1) * unit / (0.5 * (q + std::sqrt(q * q + 4.0 * q))), 1.0, 1e-10);
    }
  }
}

}  // namespace
}  // namespace credence::internal
