// The law of the normals on 1e8 of them. Takes seconds, so it has to be asked for:
//   montecarlo_tests --gtest_also_run_disabled_tests --gtest_filter='NormalLaw*'
// What noise_test.cpp checks at every build is the same on fewer.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/random/noise.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kSlotsDrawn = 2, kStepsDrawn = 1024;
constexpr std::int64_t kBlock = kSlotsDrawn * kStepsDrawn * NoiseSource::kLanes;  ///< normals drawn at a time
constexpr std::int64_t kBlocks = 100'000'000 / kBlock + 1;

/// E[x^k] of the standard normal: (k − 1)!! for an even k.
double moment(int k) {
  if (k % 2 != 0) return 0.0;
  double product = 1.0;
  for (int i = k - 1; i > 1; i -= 2) product *= i;
  return product;
}

TEST(NormalLaw, DISABLED_holds_on_a_hundred_million) {
  constexpr std::array<std::size_t, 12> kLags{1, 2, 3, 4, 5, 7, 8, 16, 32, 64, 128, 1024};
  constexpr double kCellsPerSigma = 16384.0, kReach = 9.0;
  const NoiseSource source(20040928, 0);
  std::vector<double> x(kBlock);
  std::vector<std::int64_t> cells(static_cast<std::size_t>(2.0 * kReach * kCellsPerSigma));
  std::array<double, 9> powers{};
  std::array<double, kLags.size()> lags{}, squares{};
  for (std::int64_t b = 0; b < kBlocks; ++b) {
    source.normals_of_runs(b * NoiseSource::kLanes, 1, kStepsDrawn, NoisePurpose::process, kSlotsDrawn, x);
    std::array<double, 9> sums{};
    for (const double value : x) {
      double power = 1.0;
      for (std::size_t k = 1; k <= 8; ++k) sums[k] += (power *= value);
      ++cells[static_cast<std::size_t>((value + kReach) * kCellsPerSigma)];
    }
    for (std::size_t k = 1; k <= 8; ++k) powers[k] += sums[k];
    for (std::size_t l = 0; l < kLags.size(); ++l) {
      double product = 0.0, product_of_squares = 0.0;
      for (std::size_t i = kLags[l]; i < x.size(); ++i) {
        const double p = x[i] * x[i - kLags[l]];
        product += p;
        product_of_squares += (x[i] * x[i] - 1.0) * (x[i - kLags[l]] * x[i - kLags[l]] - 1.0);
      }
      lags[l] += product;
      squares[l] += product_of_squares;
    }
  }
  const double n = static_cast<double>(kBlocks * kBlock);
  ASSERT_GE(n, 1e8);
  for (int k = 1; k <= 8; ++k) {
    const double error = std::sqrt((moment(2 * k) - moment(k) * moment(k)) / n);
    EXPECT_NEAR(powers[static_cast<std::size_t>(k)] / n, moment(k), 5.0 * error) << "moment " << k;
  }
  for (std::size_t l = 0; l < kLags.size(); ++l) {
    const double pairs = n - static_cast<double>(kBlocks) * static_cast<double>(kLags[l]);
    EXPECT_LT(std::abs(lags[l]) / std::sqrt(pairs), 5.0) << "lag " << kLags[l];
    EXPECT_LT(std::abs(squares[l]) / (2.0 * std::sqrt(pairs)), 5.0) << "lag " << kLags[l] << " of squares";
  }
  double distance = 0.0, below = 0.0;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    below += static_cast<double>(cells[c]);
    const double edge = static_cast<double>(c + 1) / kCellsPerSigma - kReach;
    distance = std::max(distance, std::abs(below / n - 0.5 * std::erfc(-edge / std::numbers::sqrt2)));
  }
  // Kolmogorov's law: P(√n D > 2.62) = 2 exp(−2 · 2.62²) = 2e-6
  EXPECT_LT(std::sqrt(n) * distance, 2.62);
  RecordProperty("normals", std::to_string(kBlocks * kBlock));
  RecordProperty("kolmogorov_smirnov", std::to_string(std::sqrt(n) * distance));
}

}  // namespace
}  // namespace credence::internal
