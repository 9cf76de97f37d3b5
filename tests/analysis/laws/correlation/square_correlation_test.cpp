#include "analysis/laws/correlation/square_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

/// Autoregressions of first order of `dim` components, mixed so that their covariance is not I.
struct Series {
  LagProducts products{1, 20};
  double sum_of_squares = 0.0;  ///< of u itself, whose covariance is I
};

Series series(std::uint64_t seed, int runs, int steps, Index dim, double phi) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Series result{LagProducts(dim, 20)};
  for (int run = 0; run < runs; ++run) {
    result.products.begin_run();
    Vector u(dim);
    for (double& x : u) x = normal(random);
    for (int k = 0; k < steps; ++k) {
      for (double& x : u) x = phi * x + std::sqrt(1.0 - phi * phi) * normal(random);
      result.sum_of_squares += u.squaredNorm();
      Vector mixed = 3.0 * u;
      if (dim > 1) mixed[1] += 2.0 * u[0];
      result.products.add(mixed);
    }
  }
  return result;
}

// 1 + 2 Σ φ^{2h} = (1 + φ²)/(1 − φ²), and what is taken as less known of N values.
TEST(SquareCorrelation, IsThatOfAnAutoregression) {
  for (const double phi : {0.3, -0.6, 0.9, 0.95}) {
    const double time = (1.0 + phi * phi) / (1.0 - phi * phi);
    for (const Index dim : {Index{1}, Index{3}}) {
      const SquareCorrelation found = square_correlation(series(7, 4, 20'000, dim, phi).products);
      EXPECT_TRUE(found.known);
      EXPECT_NEAR(found.of_sum / time, 1.0, 0.1) << phi << ' ' << dim;
      EXPECT_NEAR(found.of_component / time, 1.0, 0.2) << phi << ' ' << dim;
      EXPECT_GE(found.of_component, 0.99 * found.of_sum);
    }
  }
}

TEST(SquareCorrelation, OfWhiteValuesIsOne) {
  const SquareCorrelation found = square_correlation(series(1, 1, 5000, 2, 0.0).products);
  EXPECT_NEAR(found.of_sum, 1.0, 0.02);
  EXPECT_NEAR(found.of_component, 1.0, 0.05);
}

TEST(SquareCorrelation, IsNotKnownOfFewValuesAndBeyondTheLags) {
  EXPECT_FALSE(square_correlation(series(1, 1, 20'000, 2, 0.99).products).known);
  EXPECT_FALSE(square_correlation(series(1, 1, 200, 1, 0.9).products).known);
  EXPECT_FALSE(square_correlation(series(1, 1, 40, 1, 0.0).products).known);
}

// NIS whose normal scores have a correlation of 0.7: 1 + 2 Σ 0.7^h = 5.67.
TEST(SquareCorrelation, OfScoresIsThatOfTheValues) {
  EXPECT_NEAR(score_correlation(series(3, 1, 50'000, 1, 0.7).products).of_sum, 1.7 / 0.3, 0.5);
}

// Each tail of the sum as a χ² of fewer values, at 2.5 %: three studies in four of what could be judged are.
TEST(SquareCorrelation, TheSumHasTheTailsThatItSays) {
  constexpr int kStudies = 400;
  constexpr double kTail = 0.025, kMost = 0.05;  // approximate, as said
  for (const double phi : {0.5, 0.9}) {
    int high = 0, low = 0, known = 0;
    for (int i = 0; i < kStudies; ++i) {
      const Series s = series(static_cast<std::uint64_t>(100 + i), 1, 1000, 2, phi);
      const SquareCorrelation found = square_correlation(s.products);
      if (!found.known) continue;
      ++known;
      const double dof = 2000.0 / found.of_sum, sum = s.sum_of_squares / found.of_sum;
      high += chi_square_survival(sum, dof) <= kTail ? 1 : 0;
      low += chi_square_cdf(sum, dof) <= kTail ? 1 : 0;
    }
    EXPECT_GE(known, 3 * kStudies / 4) << phi;
    const double most = kMost * known + 5.0 * std::sqrt(kMost * known);
    EXPECT_LE(high, most) << phi;
    EXPECT_LE(low, most) << phi;
  }
}

}  // namespace
}  // namespace credence::internal
