#include "analysis/tuning/noise_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

constexpr double kNoGate = std::numeric_limits<double>::infinity();

/// NIS of two dof, in the mean `scale` times what is expected, with the memory of the innovations.
std::vector<double> nis_of(int count, double scale, unsigned seed, double memory = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(scale));
  std::vector<double> nis;
  double u = normal(random), v = normal(random);
  for (int i = 0; i < count; ++i) {
    nis.push_back(u * u + v * v);
    u = memory * u + std::sqrt(1.0 - memory * memory) * normal(random);
    v = memory * v + std::sqrt(1.0 - memory * memory) * normal(random);
  }
  return nis;
}

NoiseScale scale_of(const std::vector<std::vector<double>>& runs, double gate = kNoGate) {
  return noise_scale(runs, 2.0, gate, 0.95);
}

bool misses(const NoiseScale& scale, double truth) { return scale.lower > truth || scale.upper < truth; }

// Of 95 % intervals; 5 standard errors of the binomial count.
TEST(NoiseScale, ItsIntervalMissesAsSeldomAsItShould) {
  constexpr int kRecordings = 200;
  int missed = 0;
  for (unsigned seed = 0; seed < kRecordings; ++seed)
    missed += misses(scale_of({nis_of(300, 1.0, seed)}), 1.0) ? 1 : 0;
  EXPECT_LE(missed, 0.05 * kRecordings + 5 * std::sqrt(0.05 * 0.95 * kRecordings));
  EXPECT_GT(missed, 0) << "an interval that holds everything tells nothing";
}

// Var(NIS/2) = 1 for 2 dof, so its standard error is scale/√N.
TEST(NoiseScale, IsThatOfTheNoise) {
  for (const double scale : {0.07, 4.0}) {
    const NoiseScale found = scale_of({nis_of(2000, scale, 2)});
    EXPECT_NEAR(found.scale, scale, 5 * scale / std::sqrt(2000.0));
    EXPECT_LT(found.lower, scale * 1.02);
    EXPECT_GT(found.upper, scale * 0.98);
  }
}

TEST(NoiseScale, UndoesTheCutOfAGate) {
  const double gate = chi_square_quantile(0.8, 2);
  std::vector<double> nis = nis_of(4000, 0.5, 4);
  std::erase_if(nis, [&](double x) { return x > gate; });
  const NoiseScale found = scale_of({nis}, gate);
  EXPECT_NEAR(found.scale, 0.5, 0.05);
  EXPECT_LT(found.lower, 0.5 * 1.03);
  EXPECT_GT(found.upper, 0.5 * 0.97);
  EXPECT_LT(scale_of({nis}).scale, 0.95 * found.scale) << "without it the mean is that of the cut law";
}

TEST(NoiseScale, OfSlowInnovationsHasAWideInterval) {
  const NoiseScale wide = scale_of({nis_of(900, 1, 8, 0.97)}), narrow = scale_of({nis_of(900, 1, 8)});
  EXPECT_EQ(wide.stretches, 5);
  EXPECT_EQ(narrow.stretches, 20);
  EXPECT_GT(wide.upper - wide.lower, 3 * (narrow.upper - narrow.lower));
}

/// Each value as long as so many.
std::vector<double> lasting(int count, int each, double scale, unsigned seed) {
  const std::vector<double> white = nis_of(count / each, scale, seed);
  std::vector<double> nis;
  for (int i = 0; i < count / each * each; ++i) nis.push_back(white[static_cast<std::size_t>(i / each)]);
  return nis;
}

// Whatever the runs: those that linger cannot be cut into many stretches and count all the same, and so does
// the end of a run that does not divide into stretches of one length.
TEST(NoiseScale, LiesWithinItsInterval) {
  for (const unsigned count : {1U, 3U, 8U, 20U}) {
    std::vector<std::vector<double>> runs;
    for (unsigned i = 0; i < count; ++i)
      runs.push_back(i % 4 == 1 ? lasting(119, 30, 50.0, 40 + i) : nis_of(119, 1.0, i));
    for (auto value = runs.front().end() - 17; value != runs.front().end(); ++value) *value *= 9.0;
    const NoiseScale scale = scale_of(runs);
    if (!scale.reason.empty()) continue;
    EXPECT_LT(scale.lower, scale.scale) << count << " runs";
    EXPECT_GT(scale.upper, scale.scale) << count << " runs";
  }
}

// Five runs of a few correlation times each; stretches by the correlation of each run alone missed in 11 %.
TEST(NoiseScale, ItsIntervalHoldsOfFewShortRunsOfSlowInnovations) {
  constexpr int kRecordings = 3000;
  int missed = 0, given = 0;
  for (unsigned recording = 0; recording < kRecordings; ++recording) {
    std::vector<std::vector<double>> runs;
    for (unsigned i = 0; i < 5; ++i) runs.push_back(nis_of(60, 1.0, 5 * recording + i, 0.9));
    const NoiseScale scale = scale_of(runs);
    if (!scale.reason.empty()) continue;
    ++given;
    missed += misses(scale, 1.0) ? 1 : 0;
  }
  EXPECT_GT(given, kRecordings / 2);
  EXPECT_LE(missed, 0.06 * given + 5 * std::sqrt(0.06 * 0.94 * given));
}

// Runs whose covariances are wrong by factors of their own, 1/2 and an exponential variable, 1.5 in the mean.
TEST(NoiseScale, ItsIntervalIsOfFurtherRunsToo) {
  constexpr int kRecordings = 200;
  std::mt19937_64 random(17);
  std::exponential_distribution<double> exponential;
  int missed = 0;
  for (unsigned recording = 0; recording < kRecordings; ++recording) {
    std::vector<std::vector<double>> runs;
    for (unsigned i = 0; i < 30; ++i)
      runs.push_back(nis_of(50, 0.5 + exponential(random), 1000 + 30 * recording + i));
    missed += misses(scale_of(runs), 1.5) ? 1 : 0;
  }
  EXPECT_LE(missed, 0.05 * kRecordings + 5 * std::sqrt(0.05 * 0.95 * kRecordings));
}

TEST(NoiseScale, OfTooShortARecordingHasNoInterval) {
  const NoiseScale scale = scale_of({nis_of(10, 1, 7)});
  EXPECT_EQ(scale.reason, "the recording is too short for its correlation in time");
  EXPECT_TRUE(std::isnan(scale.lower) && std::isnan(scale.upper));
}

}  // namespace
}  // namespace credence::internal
