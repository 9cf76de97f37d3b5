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
  TimeCorrelations in_time;
  double sum_of_squares = 0.0;  ///< of u itself, whose covariance is I
};

/// Of white values `slow` of the variance is an autoregression instead, of φ = 1 what stays in the whole run.
Series series(std::uint64_t seed, int runs, int steps, Index dim, double phi, double slow = 1.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double dof = static_cast<double>(dim) * runs * steps;
  Series result{{.lags = LongLags(dim), .runs = runs, .dof = dof}};
  for (int run = 0; run < runs; ++run) {
    LagSeries series(dim);
    Vector u(dim);
    for (double& x : u) x = normal(random);
    for (int k = 0; k < steps; ++k) {
      for (double& x : u) x = phi * x + std::sqrt(1.0 - phi * phi) * normal(random);
      Vector mixed = std::sqrt(slow) * u;
      if (slow < 1.0) {
        for (double& x : mixed) x += std::sqrt(1.0 - slow) * normal(random);
      }
      result.sum_of_squares += mixed.squaredNorm();
      mixed *= 3.0;
      if (dim > 1) mixed[1] += 2.0 / 3.0 * mixed[0];
      series.add(mixed);
    }
    result.in_time.lags.add_run(series);
  }
  return result;
}

/// The share of studies whose sum is too large, and too small, by that law, each at 2.5 %.
struct Tails {
  double high = 0.0, low = 0.0, known = 0.0;
};

Tails tails_of(int studies, int runs, int steps, Index dim, double phi, double slow = 1.0) {
  constexpr double kTail = 0.025;
  Tails tails;
  for (int i = 0; i < studies; ++i) {
    const Series s = series(static_cast<std::uint64_t>(100 + i), runs, steps, dim, phi, slow);
    const SquareCorrelation found = square_correlation(s.in_time);
    const double dof = s.in_time.dof / found.of_sum, sum = s.sum_of_squares / found.of_sum;
    tails.known += found.known ? 1.0 / studies : 0.0;
    tails.high += chi_square_survival(sum, dof) <= kTail ? 1.0 / studies : 0.0;
    tails.low += chi_square_cdf(sum, dof) <= kTail ? 1.0 / studies : 0.0;
  }
  return tails;
}

// 1 + 2 Σ φ^{2h} = (1 + φ²)/(1 − φ²), and what is taken as less known of N values.
TEST(SquareCorrelation, IsThatOfAnAutoregression) {
  for (const double phi : {0.3, -0.6, 0.9, 0.95}) {
    const double time = (1.0 + phi * phi) / (1.0 - phi * phi);
    for (const Index dim : {Index{1}, Index{3}}) {
      const SquareCorrelation found = square_correlation(series(7, 4, 20'000, dim, phi).in_time);
      EXPECT_TRUE(found.known);
      EXPECT_NEAR(found.of_sum / time, 1.0, 0.1) << phi << ' ' << dim;
      EXPECT_NEAR(found.of_component / time, 1.0, 0.2) << phi << ' ' << dim;
      EXPECT_GE(found.of_component, 0.99 * found.of_sum);
    }
  }
}

TEST(SquareCorrelation, OfWhiteValuesIsOne) {
  const SquareCorrelation found = square_correlation(series(1, 1, 5000, 2, 0.0).in_time);
  EXPECT_NEAR(found.of_sum, 1.0, 0.02);
  EXPECT_NEAR(found.of_component, 1.0, 0.05);
}

TEST(SquareCorrelation, OfFewValuesIsThatOfOneValueARun) {
  for (const Series& s : {series(1, 1, 200, 1, 0.9), series(1, 1, 15, 1, 0.0), series(1, 2, 100, 3, 0.95)}) {
    const SquareCorrelation found = square_correlation(s.in_time);
    EXPECT_FALSE(found.known);
    const double one = s.in_time.dof / static_cast<double>(s.in_time.runs * s.in_time.lags.dim());
    EXPECT_EQ(found.of_sum, one);
    EXPECT_EQ(found.of_component, one);
  }
}

// (1 + φ²)/(1 − φ²) = 99.5 at φ = 0.99 is far beyond twenty lags, where a tenth of it is.
TEST(SquareCorrelation, LastsBeyondTheShortLags) {
  EXPECT_NEAR(square_correlation(series(1, 4, 20'000, 2, 0.99).in_time).of_sum / 99.5, 1.0, 0.2);
  const double beside_white = 1.0 + 0.04 * 98.5;
  EXPECT_NEAR(square_correlation(series(1, 4, 20'000, 2, 0.99, 0.2).in_time).of_sum / beside_white, 1.0, 0.2);
}

// 1 + n c² of what stays with a share c of the variance; c is taken for more than it looks.
TEST(SquareCorrelation, OfWhatStaysInWholeRunsGrowsWithThem) {
  const SquareCorrelation found = square_correlation(series(1, 30, 1000, 1, 1.0, 0.2).in_time);
  EXPECT_FALSE(found.known);
  EXPECT_GT(found.of_sum, 1.0 + 1000 * 0.04);
  EXPECT_LT(found.of_sum, 3.0 * (1.0 + 1000 * 0.04));
}

// NIS whose normal scores have a correlation of 0.7: 1 + 2 Σ 0.7^h = 5.67.
TEST(SquareCorrelation, OfScoresIsThatOfTheValues) {
  EXPECT_NEAR(score_correlation(series(3, 1, 50'000, 1, 0.7).in_time).of_sum, 1.7 / 0.3, 0.5);
}

// Each tail of the sum as a χ² of fewer values, at 2.5 %: approximate, as said.
TEST(SquareCorrelation, TheSumHasTheTailsThatItSays) {
  constexpr int kStudies = 400;
  constexpr double kMost = 0.05;
  const double most = kMost + 5.0 * std::sqrt(kMost / kStudies);
  for (const double phi : {0.5, 0.9, 0.95}) {
    const Tails tails = tails_of(kStudies, 1, 1500, 2, phi);
    EXPECT_GE(tails.known, 0.75) << phi;
    EXPECT_LE(tails.high, most) << phi;
    EXPECT_LE(tails.low, most) << phi;
  }
}

// A filter that considers a bias, and does not estimate it, has such innovations: S is right. Of few runs
// they are not too large for it; that they are too small is not held against chance where c is seen to be
// small.
TEST(SquareCorrelation, WhatStaysInARunIsNotTakenForManyValues) {
  constexpr int kStudies = 200;
  constexpr double kMost = 0.05;
  const double most = kMost + 5.0 * std::sqrt(kMost / kStudies);
  for (const double phi : {1.0, 0.99}) {
    for (const double slow : {0.1, 0.4, 0.6}) {
      EXPECT_LE(tails_of(kStudies, 1, 1500, 1, phi, slow).high, most) << phi << ' ' << slow;
      EXPECT_LE(tails_of(kStudies, 4, 500, 1, phi, slow).high, most) << phi << ' ' << slow;
      const Tails many = tails_of(kStudies, 30, 200, 1, phi, slow);
      EXPECT_LE(many.high, most) << phi << ' ' << slow;
      EXPECT_LE(many.low, most) << phi << ' ' << slow;
    }
  }
}

}  // namespace
}  // namespace credence::internal
