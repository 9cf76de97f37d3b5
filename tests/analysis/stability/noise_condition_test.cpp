#include "analysis/stability/noise_condition.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/stability/boundedness.h"
#include "core/inflation/rank_inflation.h"
#include "tests/analysis/stability/stability_problems.h"

// theory, section 5, Theorems 1 and 2.

namespace credence::internal {
namespace {

using testing::random_matrix;
using testing::random_psd;
using testing::riccati_problem;

struct Cell {
  RiccatiProblem problem;
  Matrix P0;
  std::string name;
};

/// Monobots of 1 to 4 landmarks, anchored or not, with constant ΔP of every rank and range, and P0 and R that
/// are no multiples of I.
std::vector<Cell> cells(unsigned seed) {
  std::mt19937_64 generator(seed);
  std::vector<Cell> all;
  for (Index N = 1; N <= 4; ++N) {
    for (const Index anchors : {0, 1}) {
      const LinearModel model = monobot_model(N, anchors, 0.1, 0.1, 1.0);
      for (const InflationRange range : {InflationRange::generic, InflationRange::map,
                                         InflationRange::with_vehicle, InflationRange::difference}) {
        const Index least = range == InflationRange::with_vehicle ? 1 : 0;
        for (Index rank = least; rank <= max_inflation_rank(model.layout, range); ++rank) {
          RiccatiProblem problem = riccati_problem(model);
          problem.Qt +=
              rank_inflation(model.layout, model.G,
                             {.rank = rank, .range = range, .scale = 0.2, .seed = 1000 * seed + all.size()});
          problem.R.diagonal() += random_matrix(problem.R.rows(), 1, generator).cwiseAbs2();
          const Matrix P0 = random_psd(N + 1, N + 1, generator);
          all.push_back(
              {std::move(problem), P0,
               ::testing::PrintToString(std::vector<Index>{N, anchors, static_cast<Index>(range), rank})});
        }
      }
    }
  }
  return all;
}

double least_eigenvalue(const Matrix& M) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(M, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

TEST(NoiseCondition, DecidesWhatDoublingMeasuresAndNamesTheRate) {
  // What 2^21 steps by doubling keep of a trace, and of a slope that is small beside it, where P grows.
  constexpr double kSlope = 1e-4;
  std::vector<Cell> all;
  for (const unsigned seed : {1U, 2U, 3U}) {
    for (Cell& cell : cells(seed)) all.push_back(std::move(cell));
  }
  int bounded = 0, growing = 0;
  for (const Cell& cell : all) {
    SCOPED_TRACE(cell.name);
    const NoiseCondition c = noise_condition(cell.problem, cell.P0);
    const MeasuredBoundedness measured = measure_boundedness(cell.problem, cell.P0);
    EXPECT_EQ(c.bounded(), measured.bounded);
    EXPECT_EQ(c.bounded(), exact_boundedness(cell.problem.F, cell.problem.H, cell.problem.Qt).bounded());
    ++(c.bounded() ? bounded : growing);
    // The recursion starts with a measurement of P0 itself: after k steps there are k − 1 noises in the
    // posterior and Q_t is added to that.
    const double rounding = c.bounded() ? 1e-9 : kSlope;
    const std::vector<double> traces = riccati_growth(cell.problem, cell.P0).traces;
    for (std::size_t doubling = 0; doubling < traces.size(); ++doubling) {
      const double noises = std::ldexp(1.0, static_cast<int>(doubling)) - 1.0;
      const double most = noises * c.growth_per_step() + c.trace_bound() + cell.problem.Qt.trace();
      EXPECT_LE(traces[doubling], most * (1.0 + rounding)) << "after 2^" << doubling;
      EXPECT_GE(traces[doubling], noises * c.rate * (1.0 - rounding)) << "after 2^" << doubling;
    }
    if (c.bounded()) {
      EXPECT_EQ(c.rate, 0.0);
      EXPECT_EQ(c.growth_per_step(), 0.0);
      continue;
    }
    EXPECT_GE(measured.trace_per_step, c.rate * (1.0 - kSlope));
    EXPECT_NEAR(measured.trace_per_step / c.growth_per_step(), 1.0, kSlope);
    const Vector& u = c.direction;
    EXPECT_NEAR(u.norm(), 1.0, 1e-12);
    EXPECT_LT((cell.problem.H * u).norm(), 1e-7);
    const Vector back = cell.problem.Qt.completeOrthogonalDecomposition().solve(u);
    EXPECT_LT((cell.problem.Qt * back - u).norm(), 1e-7);  // u is in the range
    EXPECT_NEAR(c.rate * u.dot(back), 1.0, 1e-6);          // c = 1/(uᵀ Q_t⁺ u)
  }
  EXPECT_GT(bounded, 150);
  EXPECT_GT(growing, 40);
}

TEST(NoiseCondition, HoldsPBetweenItsBoundsAtEveryStep) {
  double tightest = 0.0;
  for (const Cell& cell : cells(17)) {
    SCOPED_TRACE(cell.name);
    const NoiseCondition c = noise_condition(cell.problem, cell.P0);
    Matrix prior = cell.P0;  // of the measurement that follows
    for (int noises = 0; noises < 40; ++noises) {
      const Matrix posterior = riccati_step(cell.problem, prior) - cell.problem.Qt;
      const Matrix grown = noises * c.S;
      const double rounding = 1e-9 * (grown + c.B).trace();
      EXPECT_GT(least_eigenvalue(posterior - grown), -rounding) << noises;
      EXPECT_GT(least_eigenvalue(grown + c.B - posterior), -rounding) << noises;
      tightest = std::max(tightest, posterior.trace() / (grown + c.B).trace());
      prior = posterior + cell.problem.Qt;
    }
  }
  EXPECT_GT(tightest, 0.5);  // a bound that nothing comes near would prove little
  EXPECT_LE(tightest, 1.0 + 1e-9);
}

TEST(NoiseCondition, OfAWalkThatNobodySeesIsTheWalkItself) {
  const RiccatiProblem problem = testing::scalar_problem(1.0, 0.0, 0.3);
  const NoiseCondition c = noise_condition(problem, Matrix::Ones(1, 1));
  EXPECT_FALSE(c.bounded());
  EXPECT_NEAR(c.rate, 0.3, 1e-15);
  EXPECT_NEAR(c.B(0, 0), 1.0, 1e-15);
  const RiccatiProblem blind{Matrix::Identity(2, 2), Matrix(0, 2), Matrix::Zero(2, 2), Matrix(0, 0)};
  EXPECT_TRUE(noise_condition(blind, Matrix::Identity(2, 2)).bounded());
  EXPECT_NEAR(noise_condition(blind, Matrix::Identity(2, 2)).trace_bound(), 2.0, 1e-15);
}

TEST(NoiseCondition, IsAboutStatesThatStandStill) {
  const RiccatiProblem problem = testing::scalar_problem(0.9, 1.0, 0.1);
  EXPECT_THROW(noise_condition(problem, Matrix::Ones(1, 1)), std::invalid_argument);
}

/// P after so many steps of a recursion whose H and Q_t are given for every step k = 1, 2, …
template <typename At>
Matrix followed(const At& at, Matrix P, int steps) {
  for (int k = 1; k <= steps; ++k) P = riccati_step(at(k), P);
  return P;
}

/// One period: three landmarks on a line of which one is seen at each of four steps, and noise along one
/// direction at each of them, in a range of `rank` dimensions.
std::vector<RiccatiProblem> period(Index rank, std::mt19937_64& generator) {
  const LinearModel model = monobot_model(3, 0, 0.1, 0.1, 1.0);
  const Matrix range = random_matrix(4, rank, generator);
  std::vector<RiccatiProblem> steps;
  for (Index j = 0; j < 4; ++j) {
    RiccatiProblem step = riccati_problem(model);
    step.H = model.H.row(j % 3).eval();
    step.R = testing::matrix_1x1(0.1);
    const Matrix noise = range * random_matrix(rank, 1, generator);
    step.Qt = 0.1 * noise * noise.transpose();
    steps.push_back(std::move(step));
  }
  return steps;
}

TEST(PeriodicNoise, IsBoundedExactlyIfItsSumTouchesNoUnobservableDirection) {
  std::mt19937_64 generator(5);
  int bounded = 0, growing = 0;
  for (int i = 0; i < 12; ++i) {
    const Index rank = 1 + i % 4;
    SCOPED_TRACE(rank);
    const std::vector<RiccatiProblem> steps = period(rank, generator);
    AccumulatedNoise noise(4);
    std::vector<Matrix> F, H{Matrix(0, 4)};
    for (const RiccatiProblem& step : steps) {
      noise.add(step.F, step.Qt);
      F.push_back(step.F);
      H.push_back(step.H);
    }
    const ExactBoundedness condition = exact_boundedness(noise, local_observability(F, H), kPsdRankTolerance);
    const auto at = [&](int k) { return steps[static_cast<std::size_t>(k - 1) % 4]; };
    const Matrix half = followed(at, Matrix::Identity(4, 4), 30'000), full = followed(at, half, 30'000);
    const double growth = (full - half).trace() / half.trace();
    EXPECT_EQ(condition.bounded(), growth < 0.01) << growth;
    EXPECT_TRUE(growth < 1e-3 || growth > 0.1) << growth;
    ++(condition.bounded() ? bounded : growing);
  }
  EXPECT_GE(bounded, 5);
  EXPECT_GE(growing, 3);
}

TEST(PeriodicNoise, NoSingleStepNeedsToTouchTheDirectionThatGrows) {
  // r and f alone at even and odd steps: neither noise holds (1, 1), which f − r does not see; their sum
  // does.
  RiccatiProblem step = riccati_problem(monobot_model(1, 0, 0.1, 0.1, 1.0));
  const auto at = [&](int k) {
    step.Qt = Matrix::Zero(2, 2);
    step.Qt(k % 2, k % 2) = 0.1;
    return step;
  };
  for (const int k : {1, 2}) EXPECT_TRUE(noise_condition(at(k), Matrix::Identity(2, 2)).bounded());
  const Matrix half = followed(at, Matrix::Identity(2, 2), 10'000), full = followed(at, half, 10'000);
  EXPECT_NEAR(full.trace() / half.trace(), 2.0, 0.01);
}

TEST(DyingNoise, IsBoundedThoughItTouchesWhatNobodySees) {
  const RiccatiProblem quiet = riccati_problem(monobot_model(1, 0, 0.0, 0.1, 1.0));
  const Vector u = Vector::Constant(2, std::sqrt(0.5));  // f − r does not see it
  const auto dying = [&](double power) {
    return [&quiet, &u, power](int k) {
      RiccatiProblem step = quiet;
      step.Qt = std::pow(k, -power) * u * u.transpose();
      return step;
    };
  };
  const auto along_u = [&](const auto& noise, int steps) {
    return u.dot(followed(noise, Matrix::Identity(2, 2), steps) * u);
  };
  AccumulatedNoise sum(2);
  for (int k = 1; k <= 1000; ++k) sum.add(quiet.F, dying(2.0)(k).Qt);
  EXPECT_FALSE(exact_boundedness(sum, observability(quiet.F, quiet.H), kPsdRankTolerance)
                   .bounded());  // of periodic noise only

  constexpr double kPi = 3.14159265358979323846;
  EXPECT_LT(along_u(dying(2.0), 20'000), 1.0 + kPi * kPi / 6.0);
  EXPECT_GT(along_u(dying(2.0), 1000), 2.6);
  // 1/k: as log k, without end, and with a growth exponent of 0.
  EXPECT_NEAR(along_u(dying(1.0), 20'000) - along_u(dying(1.0), 1000), std::log(20.0), 1e-3);
}

}  // namespace
}  // namespace credence::internal
