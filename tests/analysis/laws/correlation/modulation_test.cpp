#include "analysis/laws/correlation/modulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace credence::internal {
namespace {

/// Squares of two errors that are correlated in time by phi, their variance that of `of_step`, as NEES over
/// its dof.
std::vector<double> squares(std::uint64_t seed, int steps, double phi, double dof_of_t,
                            const std::function<double(int)>& of_step) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::gamma_distribution<double> gamma(0.5 * dof_of_t, 2.0);
  double e[2] = {normal(random), normal(random)};
  std::vector<double> values;
  for (int k = 0; k < steps; ++k) {
    for (double& x : e) x = phi * x + std::sqrt(1.0 - phi * phi) * normal(random);
    const double heavy = dof_of_t > 0.0 ? (dof_of_t - 2.0) / gamma(random) : 1.0;
    values.push_back(0.5 * heavy * of_step(k) * (e[0] * e[0] + e[1] * e[1]));
  }
  return values;
}

int rejected(int studies, int steps, double phi, double dof_of_t, const std::function<double(int)>& of_step) {
  int count = 0;
  for (int i = 0; i < studies; ++i)
    count +=
        modulation(squares(static_cast<std::uint64_t>(i), steps, phi, dof_of_t, of_step)).p_value <= 0.05;
  return count;
}

// By five standard errors of a binomial law.
TEST(Modulation, AShortMemoryIsNone) {
  constexpr int kStudies = 200;
  const auto constant = [](int) { return 1.0; };
  for (const double phi : {0.0, 0.6, 0.9}) {
    for (const double dof_of_t : {0.0, 5.0}) {
      EXPECT_LE(rejected(kStudies, 2000, phi, dof_of_t, constant),
                0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies))
          << phi << ' ' << dof_of_t;
    }
  }
}

TEST(Modulation, AWaveAndAStepAreSeen) {
  constexpr int kStudies = 20;
  for (const double phi : {0.0, 0.8}) {
    for (const double period : {20.0, 200.0, 2000.0}) {
      const auto wave = [period](int k) { return 1.0 + 0.7 * std::sin(2.0 * std::numbers::pi * k / period); };
      EXPECT_GE(rejected(kStudies, 2000, phi, 0.0, wave), kStudies - 1) << phi << ' ' << period;
    }
    const auto step = [](int k) { return k < 700 ? 0.5 : 1.27; };
    EXPECT_GE(rejected(kStudies, 2000, phi, 5.0, step), kStudies - 1) << phi;
  }
}

// A wave of 0.7 in 200 values, and one in all of them, that no single frequency of the others comes near.
TEST(Modulation, TellsTheWaveAndItsSize) {
  for (const double period : {200.0, 2000.0}) {
    const auto wave = [period](int k) { return 1.0 + 0.7 * std::sin(2.0 * std::numbers::pi * k / period); };
    const Modulation found = modulation(squares(5, 2000, 0.0, 0.0, wave));
    EXPECT_DOUBLE_EQ(found.wave, period);
    // Over half a wave the mean is 1 ± 0.7 · 2/π, and NEES of two dof has the variance of the square of its
    // mean.
    const double off = 0.7 * 2.0 / std::numbers::pi;
    EXPECT_NEAR(found.high.mean, 1.0 + off, 0.12) << period;
    EXPECT_NEAR(found.low.mean, 1.0 - off, 0.12) << period;
    EXPECT_NEAR(found.low.error, std::sqrt((1.0 - off) * (1.0 - off) / 1000.0), 0.01) << period;
  }
}

// A level is not beyond that of the values there, as a wave that is fitted to a step is by 4/π. With a memory
// of 0.6 squares have one of 0.36, and a mean of n values is off by √(1.36/0.64 / n) times one.
TEST(Modulation, LevelsAreThoseOfAStep) {
  const auto step = [](int k) { return k < 1000 ? 1.0 : 4.0; };
  const Modulation found = modulation(squares(6, 2000, 0.6, 0.0, step));
  EXPECT_NEAR(2.5 * found.low.mean, 1.0, 5.0 * 2.5 * found.low.error);
  EXPECT_NEAR(2.5 * found.high.mean, 4.0, 5.0 * 2.5 * found.high.error);
  EXPECT_NEAR(2.5 * found.high.error, 4.0 * std::sqrt(1.36 / 0.64 / 1000.0), 0.06);
  EXPECT_NEAR(2.5 * found.low.error, std::sqrt(1.36 / 0.64 / 1000.0), 0.02);
}

TEST(Modulation, IsOfEveryScaleAndNoneOfFewOrEqualValues) {
  const std::vector<double> values = squares(1, 300, 0.3, 5.0, [](int) { return 1.0; });
  std::vector<double> scaled = values;
  for (double& x : scaled) x = 7.0 * x * x;
  EXPECT_EQ(modulation(scaled).p_value, modulation(values).p_value);
  EXPECT_TRUE(std::isnan(modulation(std::vector<double>(300, 2.0)).p_value));
  EXPECT_TRUE(std::isnan(modulation(std::span(values).first(134)).p_value));
  EXPECT_FALSE(std::isnan(modulation(std::span(values).first(135)).p_value));
  EXPECT_TRUE(std::isnan(modulation({}).p_value));
  scaled[7] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(modulation(scaled).p_value));
}

}  // namespace
}  // namespace credence::internal
