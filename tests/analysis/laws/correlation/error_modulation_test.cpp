#include "analysis/laws/correlation/error_modulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace credence::internal {
namespace {

using OfStep = std::function<double(Index)>;

/// Errors over σ, each correlated in time by phi[i], or by memory(k) where that is given; their variance that
/// of `of_step`.
Matrix errors_of(unsigned seed, Index steps, const std::vector<double>& phi, const OfStep& of_step,
                 const OfStep& memory = {}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Matrix z(std::ssize(phi), steps);
  for (Index i = 0; i < z.rows(); ++i) {
    double e = normal(random);
    for (Index k = 0; k < steps; ++k) {
      const double r = memory ? memory(k) : phi[static_cast<std::size_t>(i)];
      e = r * e + std::sqrt(1.0 - r * r) * normal(random);
      z(i, k) = std::sqrt(of_step(k)) * e;
    }
  }
  return z;
}

double right(Index) { return 1.0; }

int rejected(int studies, double level, const std::function<Matrix(unsigned)>& draw) {
  int count = 0;
  for (int i = 0; i < studies; ++i)
    count += error_modulation(draw(static_cast<unsigned>(i))).p_value <= level;
  return count;
}

// The parametric test of NEES alone rejects 18 to 53 % of these at 0.5 % (docs/statistics.md).
TEST(ErrorModulation, MemoriesOfSeveralLengthsAreNone) {
  constexpr int kStudies = 60;
  const std::vector<std::vector<double>> memories = {
      {0.0}, {0.9, 0.9}, {0.0, 0.97}, {0.0, 0.5, 0.97}, {0.0, 0.9, 0.99}};
  for (const std::vector<double>& phi : memories) {
    EXPECT_LE(rejected(kStudies, 0.05, [&](unsigned i) { return errors_of(i, 2000, phi, right); }),
              0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies))
        << phi.back();
  }
}

// As of a position that nothing observes for a while: its error then stays, whatever it is.
TEST(ErrorModulation, AMemoryThatIsLongerForAWhileIsNone) {
  constexpr int kStudies = 60;
  const std::vector<double> three(3, 0.0);
  for (const Index lasts : {100, 200, 1000}) {
    const auto memory = [lasts](Index k) { return k > 900 && k <= 900 + lasts ? 0.98 : 0.0; };
    const auto draw = [&](unsigned i) { return errors_of(i, 2000, three, right, memory); };
    EXPECT_LE(rejected(kStudies, 0.005, draw), 0.005 * kStudies + 5.0 * std::sqrt(0.005 * 0.995 * kStudies))
        << lasts;
  }
}

// Windows that are shorter than the run see it: of all of it together the memory is half of what it is at
// times, and a quarter of these would be rejected.
TEST(ErrorModulation, AMemoryThatComesAndGoesIsNone) {
  constexpr int kStudies = 60;
  const auto memory = [](Index k) { return k / 50 % 2 == 0 ? 0.0 : 0.995; };
  const std::vector<double> many(24, 0.0);
  const auto draw = [&](unsigned i) { return errors_of(i, 2000, many, right, memory); };
  EXPECT_LE(rejected(kStudies, 0.05, draw), 0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies));
}

// As of a bias that P claims, and that walks, beside a small error that a filter corrects. By errors that
// are brought up to the variance 1 alone, and are then as large all along, 107 of 400 were rejected at 0.005.
TEST(ErrorModulation, AnOffsetThatWalksIsNone) {
  constexpr int kStudies = 60;
  const auto draw = [](unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    constexpr double kWalk = 3.3e-5, kCorrected = 0.02, kMemory = 0.97;
    double offset = normal(random), variance = 1.0, e = 0.0;
    Matrix z(1, 2000);
    for (Index k = 0; k < z.cols(); ++k) {
      offset += std::sqrt(kWalk) * normal(random);
      variance += kWalk;
      e = kMemory * e + std::sqrt(kCorrected * (1.0 - kMemory * kMemory)) * normal(random);
      z(0, k) = (offset + e) / std::sqrt(variance + kCorrected);
    }
    return z;
  };
  EXPECT_LE(rejected(kStudies, 0.005, draw), 0.005 * kStudies + 5.0 * std::sqrt(0.005 * 0.995 * kStudies));
}

// Over half a wave of 0.7 the mean is 1 ± 0.7 · 2/π, 0.89 apart.
TEST(ErrorModulation, AWaveIsSeenAndToldByItsLength) {
  constexpr unsigned kStudies = 10;
  for (const double phi : {0.0, 0.8}) {
    for (const double period : {50.0, 200.0, 500.0}) {
      int seen = 0, told = 0;
      for (unsigned i = 0; i < kStudies; ++i) {
        const auto wave = [period](Index k) {
          return 1.0 + 0.7 * std::sin(2.0 * std::numbers::pi * static_cast<double>(k) / period);
        };
        const Modulation found = error_modulation(errors_of(100 + i, 2000, {phi, phi, phi}, wave));
        seen += found.p_value <= 1e-4;
        told += std::abs(found.wave / period - 1.0) < 0.1 &&
                std::abs(found.high.mean - found.low.mean - 0.89) < 0.3;
      }
      EXPECT_GE(seen, 8) << phi << ' ' << period;
      EXPECT_GE(told, 8) << phi << ' ' << period;
    }
  }
}

TEST(ErrorModulation, AStepIsSeen) {
  const auto step = [](Index k) { return k < 700 ? 0.5 : 1.27; };
  EXPECT_GE(rejected(10, 1e-3, [&](unsigned i) { return errors_of(i, 2000, {0.6, 0.6}, step); }), 9);
}

// The test knows neither the scale of P nor the units.
TEST(ErrorModulation, IsOfEveryScale) {
  const auto wave = [](Index k) { return 1.0 + 0.3 * std::sin(0.05 * static_cast<double>(k)); };
  const Matrix z = errors_of(3, 500, {0.2, 0.4}, wave);
  const Modulation found = error_modulation(z), scaled = error_modulation(3.0 * z);
  EXPECT_NEAR(found.p_value / scaled.p_value, 1.0, 1e-9);
  EXPECT_EQ(found.wave, scaled.wave);
  EXPECT_NEAR(found.high.mean, scaled.high.mean, 1e-9);
}

TEST(ErrorModulation, IsNoneOfFewOrEqualOrNoNumbers) {
  Matrix z = errors_of(4, 300, {0.2, 0.4}, right);
  EXPECT_GT(error_modulation(z).p_value, 0.05);
  EXPECT_TRUE(std::isnan(error_modulation(z.leftCols(129)).p_value));
  EXPECT_TRUE(std::isnan(error_modulation(Matrix(2, 0)).p_value));
  EXPECT_TRUE(std::isnan(error_modulation(Matrix::Constant(2, 300, 0.7)).p_value));
  EXPECT_TRUE(std::isnan(error_modulation(Matrix::Zero(2, 300)).p_value));
  z(0, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(error_modulation(z).p_value));
}

}  // namespace
}  // namespace credence::internal
