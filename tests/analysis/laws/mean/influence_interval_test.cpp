#include "analysis/laws/mean/influence_interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

/// Scores of an autoregression with mean zero in the long run, of unit variance and information.
RunScores autoregression(double phi, int rows, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  RunScores run{.information = std::vector<double>(static_cast<std::size_t>(rows), 1.0)};
  double value = normal(random);
  for (int k = 0; k < rows; ++k) {
    run.values.push_back(value);
    value = phi * value + std::sqrt(1.0 - phi * phi) * normal(random);
  }
  return run;
}

/// As it is at θ̂: the sum over all runs is zero; returns what θ̂ is off by.
double centred(std::vector<RunScores>& runs) {
  double sum = 0.0, information = 0.0;
  for (const RunScores& run : runs) {
    for (const double g : run.values) sum += g;
    information += static_cast<double>(run.values.size());
  }
  for (RunScores& run : runs) {
    for (double& g : run.values) g -= sum / information;
  }
  return sum / information;
}

struct Misses {
  int told = 0, missed = 0;
  double share() const { return static_cast<double>(missed) / told; }
};

Misses misses_of(int studies, int runs, double phi, int rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Misses misses;
  for (int s = 0; s < studies; ++s) {
    std::vector<RunScores> scores;
    for (int r = 0; r < runs; ++r) scores.push_back(autoregression(phi, rows, random));
    const double off = centred(scores);
    const InfluenceInterval interval = influence_interval(scores, 0.95);
    if (!interval.reason.empty()) continue;
    ++misses.told;
    misses.missed += std::abs(off) > interval.half_width ? 1 : 0;
  }
  return misses;
}

// Five standard errors above the level, also of those of which hardly half are long enough (φ = 0.8, 300
// values, 33 correlation times): stretches of a tenth missed a fifth of them.
TEST(InfluenceInterval, MissesAsSeldomAsItSaysWhereItOnlyJustExists) {
  constexpr int kStudies = 600;
  for (const auto& [phi, rows] : {std::pair{0.0, 100}, {0.4, 300}, {0.7, 300}, {0.8, 300}, {0.9, 1000}}) {
    const Misses misses = misses_of(kStudies, 1, phi, rows, 1);
    EXPECT_GE(misses.told, 50) << phi;
    EXPECT_LE(misses.share(), 0.05 + 5.0 * test::binomial_standard_error(0.05, misses.told)) << phi;
  }
  EXPECT_LE(misses_of(kStudies, 1, 0.97, 300, 2).told, kStudies / 100) << "4.6 correlation times";
}

TEST(InfluenceInterval, RunsHaveOneWhateverTheirCorrelationInTime) {
  constexpr int kStudies = 1000;
  for (const int runs : {2, 3, 5, 20}) {
    const Misses misses = misses_of(kStudies, runs, 0.999, 50, 3);
    EXPECT_EQ(misses.told, kStudies);
    EXPECT_NEAR(misses.share(), 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies)) << runs;
  }
}

// The jackknife of a mean is Student's: of 1 … 5 the variance of the mean is 2.5/5, and t(4) = 2.7764.
TEST(InfluenceInterval, OfEqualRunsItIsStudentsInterval) {
  std::vector<RunScores> runs;
  for (const double g : {1.0, 2.0, 3.0, 4.0, 5.0})
    runs.push_back({.values = {g - 3.0}, .information = {1.0}});
  const InfluenceInterval interval = influence_interval(runs, 0.95);
  EXPECT_TRUE(interval.whole_runs);
  EXPECT_NEAR(interval.half_width, 2.7764 * std::sqrt(0.5), 1e-4);
}

TEST(InfluenceInterval, RunsThatDoNotAgreeAreFound) {
  std::mt19937_64 random(4);
  const auto of = [&](double apart) {
    std::vector<RunScores> runs = {autoregression(0.3, 400, random), autoregression(0.3, 400, random)};
    for (double& g : runs[0].values) g += apart;
    centred(runs);
    return influence_interval(runs, 0.95).p_agreement;
  };
  EXPECT_GT(of(0.0), 0.01);
  EXPECT_LT(of(1.0), 0.001);  // 0.5 of each, and standard errors of 0.07
  std::vector<RunScores> one = {autoregression(0.3, 400, random)};
  EXPECT_TRUE(std::isnan(influence_interval(one, 0.95).p_agreement));
}

TEST(InfluenceInterval, WhatHasNoneHasAReason) {
  EXPECT_EQ(influence_interval({}, 0.95).reason, "nothing moves");
  const std::vector<RunScores> still = {{.values = {0.0, 0.0}, .information = {0.0, 0.0}}};
  EXPECT_EQ(influence_interval(still, 0.95).reason, "nothing moves");
  const std::vector<RunScores> exact = {{.values = {0.0, 0.0}, .information = {1.0, 0.0}}};
  EXPECT_EQ(influence_interval(exact, 0.95).reason, "the series does not vary or is not finite");
  EXPECT_THROW(influence_interval({}, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
