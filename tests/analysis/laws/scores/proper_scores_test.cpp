#include "analysis/laws/scores/proper_scores.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/special_functions/hypergeometric_1F1.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

TEST(LogScore, DensityOfAGaussian) {
  // P = diag(4, 9), e = (2, 3): density e^{−1}/(2π 6).
  const Score score = log_score(2.0, std::log(36.0), 2.0);
  EXPECT_NEAR(score.value, std::log(std::exp(-1.0) / (12.0 * std::numbers::pi)), 1e-14);
  EXPECT_NEAR(score.expected, score.value, 1e-14);
  EXPECT_NEAR(log_score(5.0, 0.3, 3.0).value - log_score(5.0, 0.3, 3.0).expected, -1.0, 1e-14);
  EXPECT_EQ(log_score(std::numeric_limits<double>::infinity(), 0.0, 1.0).value,
            -std::numeric_limits<double>::infinity());
  EXPECT_THROW(log_score(-1.0, 0.0, 1.0), std::invalid_argument);
  EXPECT_THROW(log_score(1.0, 0.0, -1.0), std::invalid_argument);
}

// CRPS of N(0, σ²) at e: σ (z (2Φ(z) − 1) + 2φ(z) − 1/√π), z = e/σ [Gneiting 2007], eq. 21.
double crps(double e, double sigma) {
  const double z = e / sigma;
  return sigma * (z * std::erf(z / std::sqrt(2.0)) +
                  2.0 * std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi) -
                  1.0 / std::sqrt(std::numbers::pi));
}

TEST(EnergyScore, OneComponentIsTheContinuousRankedProbabilityScore) {
  for (const double e : {0.0, 1e-6, 0.3, -2.0, 17.0, 1e4}) {
    const double expected = crps(e, 1.7);
    EXPECT_NEAR(energy_score(Vector::Constant(1, e), Matrix::Constant(1, 1, 1.7 * 1.7)).value, expected,
                1e-12 * (1.0 + std::abs(expected)));
    EXPECT_NEAR(1.7 * whitened_energy_score(e * e / (1.7 * 1.7), 1.0).value, expected,
                1e-12 * (1.0 + std::abs(expected)));
  }
  EXPECT_NEAR(whitened_energy_score(0.0, 1.0).expected, 1.0 / std::sqrt(std::numbers::pi), 1e-15);
}

TEST(EnergyScore, QuadratureAndClosedFormAgreeForAScaledIdentity) {
  for (const Index n : {2, 3, 8, 50}) {
    for (const double length : {0.0, 0.5, 3.0, 40.0, 1e5}) {
      Vector e = Vector::Zero(n);
      e[0] = 0.6 * length;
      e[1] = -0.8 * length;
      const Score score = energy_score(e, Matrix(4.0 * Matrix::Identity(n, n)));
      const Score whitened = whitened_energy_score(0.25 * length * length, static_cast<double>(n));
      EXPECT_NEAR(score.value, 2.0 * whitened.value, 1e-12 * (1.0 + std::abs(score.value)))
          << n << " " << length;
      EXPECT_NEAR(score.expected, 2.0 * whitened.expected, 1e-12 * score.expected) << n;
    }
  }
}

TEST(EnergyScore, WhitenedIsConfluentHypergeometric) {
  for (const double n : {1.0, 2.0, 7.0, 41.0}) {
    const double expected = boost::math::tgamma(0.5 * (n + 1.0)) / boost::math::tgamma(0.5 * n);
    for (const double nees : {0.0, 1e-3, 2.0, 55.0, 1e6}) {
      const double value =
          expected * (std::sqrt(2.0) * boost::math::hypergeometric_1F1(-0.5, 0.5 * n, -0.5 * nees) - 1.0);
      EXPECT_NEAR(whitened_energy_score(nees, n).value, value, 1e-12 * (1.0 + value)) << n << " " << nees;
    }
  }
}

TEST(EnergyScore, AnyCovarianceByMonteCarlo) {
  const Matrix L{{2.0, 0.0, 0.0}, {1.0, 0.5, 0.0}, {-0.3, 0.2, 0.01}};
  const Vector e{{1.0, -2.0, 0.5}};
  std::mt19937_64 generator(71);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector(L * Vector::NullaryExpr(3, [&] { return normal(generator); })); };
  Moments value;
  Moments expected;
  for (int i = 0; i < 200000; ++i) {
    const Vector x = draw();
    const double half = 0.5 * (x - draw()).norm();
    value.add((e - x).norm() - half);
    expected.add(half);
  }
  const Score score = energy_score(e, Matrix(L * L.transpose()));
  EXPECT_NEAR(score.value, value.mean, 5.0 * std::sqrt(value.variance() / 200000.0));
  EXPECT_NEAR(score.expected, expected.mean, 5.0 * std::sqrt(expected.variance() / 200000.0));
}

TEST(EnergyScore, IsBestOnAverageForTheTrueCovariance) {
  std::mt19937_64 generator(72);
  std::normal_distribution<double> normal;
  Moments right;
  Moments too_small;
  Moments too_large;
  const auto value = [](double nees, double scale) {
    // Errors of N(0, I_4) under a claimed covariance `scale` I.
    return std::sqrt(scale) * whitened_energy_score(nees / scale, 4.0).value;
  };
  for (int i = 0; i < 20000; ++i) {
    double nees = 0.0;
    for (int j = 0; j < 4; ++j) nees += std::pow(normal(generator), 2);
    right.add(value(nees, 1.0));
    too_small.add(value(nees, 0.5) - value(nees, 1.0));
    too_large.add(value(nees, 2.0) - value(nees, 1.0));
  }
  EXPECT_NEAR(right.mean, whitened_energy_score(0.0, 4.0).expected,
              5.0 * std::sqrt(right.variance() / 20000.0));
  EXPECT_GT(too_small.mean, 5.0 * std::sqrt(too_small.variance() / 20000.0));
  EXPECT_GT(too_large.mean, 5.0 * std::sqrt(too_large.variance() / 20000.0));
}

TEST(EnergyScore, DegenerateInput) {
  // A P of rank one, and of rank zero: the distance is |e|.
  const Score line = energy_score(Vector{{0.7, 0.0}}, Matrix{{1.0, 0.0}, {0.0, 0.0}});
  EXPECT_NEAR(line.value, crps(0.7, 1.0), 1e-12);
  const Score point = energy_score(Vector{{3.0, 4.0}}, Matrix::Zero(2, 2));
  EXPECT_NEAR(point.value, 5.0, 1e-12);
  EXPECT_EQ(point.expected, 0.0);
  EXPECT_EQ(energy_score(Vector(0), Matrix(0, 0)).value, 0.0);
  EXPECT_TRUE(std::isnan(energy_score(Vector{{1.0}}, Matrix{{-1.0}}).value));
  EXPECT_TRUE(std::isnan(energy_score(Vector{{std::nan("")}}, Matrix{{1.0}}).value));
  EXPECT_TRUE(std::isnan(whitened_energy_score(std::nan(""), 2.0).value));
  EXPECT_EQ(whitened_energy_score(std::numeric_limits<double>::infinity(), 2.0).value,
            std::numeric_limits<double>::infinity());
  EXPECT_THROW(energy_score(Vector(2), Matrix(3, 3)), std::invalid_argument);
  EXPECT_THROW(whitened_energy_score(-1.0, 2.0), std::invalid_argument);
  EXPECT_THROW(whitened_energy_score(1.0, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
