#include "analysis/laws/shape/uniform_histogram.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

TEST(GoodnessOfFitHistogram, BinsHoldTheirLowerEdge) {
  for (const std::size_t bins : {std::size_t{2}, std::size_t{8}, std::size_t{1024}}) {
    for (std::size_t i = 0; i < bins; ++i) {
      UniformHistogram histogram(bins);
      const double lower = static_cast<double>(i) / static_cast<double>(bins);
      const double upper = static_cast<double>(i + 1) / static_cast<double>(bins);
      histogram.add(lower);
      histogram.add(std::nextafter(upper, 0.0));
      ASSERT_EQ(histogram.counts()[i], 2) << i << " of " << bins;
    }
  }
  UniformHistogram histogram(8);
  histogram.add(1.0);
  EXPECT_EQ(histogram.counts().back(), 1);
}

TEST(GoodnessOfFitHistogram, CountsWhatIsNoProbability) {
  UniformHistogram histogram(4);
  for (const double bad : {-1e-300, std::nextafter(1.0, 2.0), std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    histogram.add(bad);
  }
  histogram.add(-0.0);
  EXPECT_EQ(histogram.invalid(), 5);
  EXPECT_EQ(histogram.count(), 1);
  const GoodnessOfFit test = test_uniform(histogram);
  EXPECT_FALSE(test.reason.empty());
  EXPECT_TRUE(std::isnan(test.kolmogorov_p_value) && std::isnan(test.anderson_p_value));
}

TEST(GoodnessOfFitHistogram, RefusesCountsThatAreNone) {
  const std::array<std::int64_t, 2> good{0, 3}, negative{1, -1};
  EXPECT_EQ(UniformHistogram(good, 2).invalid(), 2);
  EXPECT_THROW(UniformHistogram(negative, 0), std::invalid_argument);
  EXPECT_THROW(UniformHistogram(good, -1), std::invalid_argument);
  EXPECT_THROW(UniformHistogram(std::span(good).first(1), 0), std::invalid_argument);
  EXPECT_THROW(UniformHistogram(0), std::invalid_argument);
}

TEST(GoodnessOfFitHistogram, StatisticsByHand) {
  // F_n − u at the edges ¼, ½, ¾: 0.6 − 0.25, 0.8 − 0.5, 0.8 − 0.75.
  const std::array<std::int64_t, 4> counts{3, 1, 0, 1};
  const GoodnessOfFit test = test_uniform(UniformHistogram(counts, 0));
  EXPECT_EQ(test.count, 5);
  EXPECT_NEAR(test.kolmogorov, 0.35, 1e-15);
  EXPECT_NEAR(test.anderson, 5.0 / 4.0 * (0.35 * 0.35 / 0.1875 + 0.09 / 0.25 + 0.0025 / 0.1875), 1e-14);
  EXPECT_EQ(test.kolmogorov_p_value, kolmogorov_p_value(test.kolmogorov, 5));
  EXPECT_EQ(test.anderson_p_value, anderson_p_value(test.anderson, 5));
}

/// Over all ways, each as likely, in which n values fall in the bins: P(p ≤ level) of Kolmogorov's test and
/// the mean of A².
struct Enumerated {
  double level = 0.0, anderson = 0.0;
};
Enumerated enumerate(std::size_t bins, int values, double level) {
  const auto ways = static_cast<std::size_t>(std::pow(static_cast<double>(bins), values));
  Enumerated all;
  for (std::size_t way = 0; way < ways; ++way) {
    std::vector<std::int64_t> counts(bins, 0);
    std::size_t rest = way;
    for (int i = 0; i < values; ++i) {
      ++counts[rest % bins];
      rest /= bins;
    }
    const GoodnessOfFit test = test_uniform(UniformHistogram(counts, 0));
    all.level += (test.kolmogorov_p_value <= level ? 1.0 : 0.0) / static_cast<double>(ways);
    all.anderson += test.anderson / static_cast<double>(ways);
  }
  return all;
}

TEST(GoodnessOfFitHistogram, OfAllOutcomesRejectsNoMoreThanItsLevel) {
  for (const auto& [bins, values] : {std::pair<std::size_t, int>{2, 10}, {4, 6}, {6, 5}}) {
    for (const double level : {0.05, 0.2, 0.5}) {
      const Enumerated all = enumerate(bins, values, level);
      EXPECT_LE(all.level, level) << bins;
      // n Var F_n(u) = u (1 − u): each edge adds 1/B.
      EXPECT_NEAR(all.anderson, 1.0 - 1.0 / static_cast<double>(bins), 1e-12);
    }
    EXPECT_GT(enumerate(bins, values, 0.5).level, 0.1) << bins;
  }
}

TEST(GoodnessOfFitHistogram, IsNeverFartherThanTheValuesThemselves) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> uniform;
  for (int round = 0; round < 50; ++round) {
    std::vector<double> values(static_cast<std::size_t>(3 + 5 * round));
    UniformHistogram histogram(16);
    for (double& u : values) histogram.add(u = std::pow(uniform(generator), 1.3));
    const GoodnessOfFit exact = test_uniform(values), binned = test_uniform(histogram);
    EXPECT_LE(binned.kolmogorov, exact.kolmogorov);
    EXPECT_GE(binned.kolmogorov, exact.kolmogorov - 1.0 / 16.0);
    EXPECT_GE(binned.kolmogorov_p_value, exact.kolmogorov_p_value);
  }
}

TEST(GoodnessOfFitHistogram, WithManyBinsHasTheStatisticsOfTheValues) {
  std::mt19937_64 generator(6);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> values(400);
  UniformHistogram histogram(1 << 16);
  for (double& u : values) histogram.add(u = std::pow(uniform(generator), 1.2));
  const GoodnessOfFit exact = test_uniform(values), binned = test_uniform(histogram);
  EXPECT_NEAR(binned.kolmogorov, exact.kolmogorov, 1.0 / (1 << 16));
  EXPECT_NEAR(binned.anderson, exact.anderson, 0.01 * exact.anderson);
}

}  // namespace
}  // namespace credence::internal
