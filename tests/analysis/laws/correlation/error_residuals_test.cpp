#include "analysis/laws/correlation/error_residuals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "analysis/laws/shape/tail_weight.h"

namespace credence::internal {
namespace {

std::vector<double> residual_nees_of(const Matrix& z, const Vector& log_variances) {
  const std::vector<std::vector<double>> of_runs = residual_nees({&z, 1}, {&log_variances, 1});
  return of_runs.empty() ? std::vector<double>() : of_runs.front();
}

/// Of a σ that stays.
std::vector<double> residual_nees_of(const Matrix& z) { return residual_nees_of(z, Vector::Zero(z.cols())); }

/// z_k = φ_k z_{k−1} + √(1 − φ_k²) w_k, of variance 1 where w is.
Matrix errors_with_memory(Index n, Index rows, const std::function<double(Index)>& phi,
                          const std::function<double()>& noise) {
  constexpr Index kBefore = 200;
  Matrix z(n, rows);
  Vector state = Vector::Zero(n);
  for (Index k = -kBefore; k < rows; ++k) {
    const double f = phi(k);
    for (Index i = 0; i < n; ++i) state[i] = f * state[i] + std::sqrt(1.0 - f * f) * noise();
    if (k >= 0) z.col(k) = state;
  }
  return z;
}

std::function<double()> gaussian_noise(std::mt19937_64& random) {
  return [&random, normal = std::normal_distribution<double>()]() mutable { return normal(random); };
}

/// Student's t(5) of variance 1.
std::function<double()> student_noise(std::mt19937_64& random) {
  return [&random, t = std::student_t_distribution<double>(5.0)]() mutable {
    return std::sqrt(0.6) * t(random);
  };
}

TEST(ErrorResiduals, OfOneStateAreThoseOfItsRegression) {
  std::mt19937_64 random(31);
  const Matrix z = errors_with_memory(
      1, 300, [](Index) { return 0.7; }, gaussian_noise(random));
  double products = 0.0, squares = 0.0;
  for (Index k = 1; k < 300; ++k) {
    products += z(0, k) * z(0, k - 1);
    squares += z(0, k - 1) * z(0, k - 1);
  }
  const double slope = products / squares;
  std::vector<double> expected;
  for (Index k = 1; k < 300; ++k) expected.push_back(std::pow(z(0, k) - slope * z(0, k - 1), 2));
  const double mean = std::accumulate(expected.begin(), expected.end(), 0.0) / 299.0;
  const std::vector<double> nees = residual_nees_of(z);
  ASSERT_EQ(nees.size(), 299U);
  for (std::size_t k = 0; k < nees.size(); ++k) EXPECT_NEAR(nees[k], expected[k] / mean, 1e-9);
}

TEST(ErrorResiduals, AreTheSameInAnyCoordinates) {
  std::mt19937_64 random(32);
  const Matrix z = errors_with_memory(
      3, 400, [](Index) { return 0.9; }, gaussian_noise(random));
  Matrix T(3, 3);
  T << 2.0, 0.3, 0.0, -1.0, 5.0, 0.7, 0.2, 0.0, 0.01;
  const std::vector<double> of_z = residual_nees_of(z), of_Tz = residual_nees_of(T * z);
  ASSERT_EQ(of_z.size(), 399U);
  ASSERT_EQ(of_Tz.size(), 399U);
  for (std::size_t k = 0; k < of_z.size(); ++k) EXPECT_NEAR(of_Tz[k], of_z[k], 1e-8 * (1.0 + of_z[k]));
}

// How often tails are too heavy at 1 % of NEES and of the residuals.
struct TailsFound {
  int of_nees = 0, of_residuals = 0;
};

TailsFound tails_found(int studies, double memory, const std::function<double()>& noise) {
  TailsFound found;
  for (int study = 0; study < studies; ++study) {
    const Matrix z = errors_with_memory(
        2, 500, [memory](Index) { return memory; }, noise);
    const Vector squares = 0.5 * z.colwise().squaredNorm();
    const std::vector<std::vector<double>> nees = {{squares.begin(), squares.end()}},
                                           residuals = {residual_nees_of(z)};
    found.of_nees += heavy_tail_p_value(tails_of_pieces(nees, 2.0)) <= 0.01;
    found.of_residuals += heavy_tail_p_value(tails_of_pieces(residuals, 2.0)) <= 0.01;
  }
  return found;
}

// Simulated with the same formulas in numpy: 95 of 100 by the residuals, 6 by NEES.
TEST(ErrorResiduals, ShowHeavyTailsThatAMemoryHides) {
  std::mt19937_64 random(33);
  const TailsFound found = tails_found(100, 0.8, student_noise(random));
  EXPECT_GE(found.of_residuals, 84);  // 5 standard errors of 95 in 100
  EXPECT_LE(found.of_nees, 18);       // and of 6
}

TEST(ErrorResiduals, OfGaussianErrorsHaveNoHeavyTails) {
  std::mt19937_64 random(34);
  const TailsFound found = tails_found(1000, 0.8, gaussian_noise(random));
  EXPECT_LE(found.of_residuals, 26);  // 5 standard errors above 10
}

// A fix every tenth row, or in a tenth of them, between which errors hardly change: what is new is of two
// sizes.
TEST(ErrorResiduals, OfAMemoryThatComesAndGoesAreNone) {
  std::mt19937_64 random(35);
  const auto phi = [](Index k) { return k % 10 == 0 ? 0.3 : 0.99; };
  std::bernoulli_distribution fix(0.1);
  const auto at_random = [&](Index) { return fix(random) ? 0.3 : 0.99; };
  EXPECT_TRUE(residual_nees_of(errors_with_memory(2, 500, at_random, gaussian_noise(random))).empty());
  std::vector<Matrix> runs;
  for (int run = 0; run < 5; ++run)
    runs.push_back(errors_with_memory(2, 200, at_random, gaussian_noise(random)));
  EXPECT_TRUE(residual_nees(runs, std::vector<Vector>(5, Vector::Zero(200))).empty());
  EXPECT_TRUE(residual_nees_of(errors_with_memory(2, 500, phi, gaussian_noise(random))).empty());
}

// As of a constant that few rows tell as much as there is to be told: what is new in it has a direction of
// its own in these rows, and is nothing in all others.
TEST(ErrorResiduals, OfAStateThatSoonStaysAsItIsAreNone) {
  std::mt19937_64 random(38);
  Matrix z(3, 300);
  z.topRows(2) = errors_with_memory(
      2, 300, [](Index) { return 0.8; }, gaussian_noise(random));
  ASSERT_FALSE(residual_nees_of(z.topRows(2)).empty());
  const auto noise = gaussian_noise(random);
  for (const double rows : {1.0, 15.0}) {
    double state = noise();
    for (Index k = 0; k < z.cols(); ++k) {
      state += std::exp(-static_cast<double>(k) / rows) * noise();
      z(2, k) = state + 1e-9 * noise();
    }
    EXPECT_TRUE(residual_nees_of(z).empty()) << rows;
  }
}

// A σ that is too small and too large in turn is no matter of tails.
TEST(ErrorResiduals, OfASizeThatGoesUpAndDownAreNone) {
  std::mt19937_64 random(37);
  Matrix z = errors_with_memory(
      2, 1000, [](Index) { return 0.8; }, gaussian_noise(random));
  ASSERT_FALSE(residual_nees_of(z).empty());
  for (Index k = 0; k < z.cols(); ++k)
    z.col(k) *= 1.0 + 0.6 * std::sin(0.02 * std::numbers::pi * static_cast<double>(k));
  EXPECT_TRUE(residual_nees_of(z).empty());
}

// What is new in an error is a tenth of it here: changes of σ² by 1 % do not show in it, by 3 % they do.
// Those at the start are of its own.
TEST(ErrorResiduals, OfASigmaThatChangesAreNone) {
  std::mt19937_64 random(39);
  const Matrix z = errors_with_memory(
      2, 500, [](Index) { return std::sqrt(0.9); }, gaussian_noise(random));
  const auto of_changes = [&](Index from, double change) {
    const Vector changing =
        Vector::NullaryExpr(z.cols(), [&](Index k) { return k > from && k % 2 == 0 ? change : 0.0; });
    return residual_nees_of(z, changing);
  };
  EXPECT_EQ(of_changes(0, 0.01).size(), 499U);
  EXPECT_TRUE(of_changes(0, 0.03).empty());
  const Vector learning =
      Vector::NullaryExpr(z.cols(), [](Index k) { return 10.0 * std::exp(-0.2 * static_cast<double>(k)); });
  EXPECT_EQ(residual_nees_of(z, learning).size(), 499U);
}

TEST(ErrorResiduals, AreNoneOfFewRowsOrOfWhatDoesNotVary) {
  std::mt19937_64 random(36);
  const auto phi = [](Index) { return 0.5; };
  Matrix z = errors_with_memory(2, 200, phi, gaussian_noise(random));
  ASSERT_FALSE(residual_nees_of(z).empty());
  EXPECT_TRUE(residual_nees_of(z.leftCols(129)).empty());
  EXPECT_TRUE(residual_nees_of(Matrix(0, 200)).empty());
  EXPECT_TRUE(residual_nees_of(errors_with_memory(12, 239, phi, gaussian_noise(random))).empty());
  Matrix same = z;
  same.row(1) = same.row(0);
  EXPECT_TRUE(residual_nees_of(same).empty());
  z(1, 50) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(residual_nees_of(z).empty());
}

}  // namespace
}  // namespace credence::internal
