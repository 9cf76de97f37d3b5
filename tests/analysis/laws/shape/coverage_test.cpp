#include "analysis/laws/shape/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(Coverage, ExpectedSharesOfTheEllipsoids) {
  // One dimension: erf(k/√2). Two: 1 − exp(−k²/2).
  EXPECT_NEAR(expected_coverage(1.0, 1.0), std::erf(1.0 / std::sqrt(2.0)), 1e-14);
  EXPECT_NEAR(expected_coverage(2.0, 1.0), 0.9544997361, 1e-10);
  EXPECT_NEAR(expected_coverage(3.0, 2.0), 1.0 - std::exp(-4.5), 1e-14);
  EXPECT_EQ(expected_coverage(0.0, 3.0), 0.0);
  EXPECT_THROW(expected_coverage(-1.0, 3.0), std::invalid_argument);
}

TEST(Coverage, ClopperPearsonKnownIntervals) {
  // 0 of n: upper = 1 − (α/2)^{1/n}; n of n mirrors it.
  const double bound = 1.0 - std::pow(0.025, 1.0 / 20.0);
  EXPECT_NEAR(clopper_pearson({.inside = 0, .total = 20}, 0.95).upper, bound, 1e-12);
  EXPECT_EQ(clopper_pearson({.inside = 0, .total = 20}, 0.95).lower, 0.0);
  EXPECT_NEAR(clopper_pearson({.inside = 20, .total = 20}, 0.95).lower, 1.0 - bound, 1e-12);
  EXPECT_EQ(clopper_pearson({.inside = 20, .total = 20}, 0.95).upper, 1.0);
  // Printed in the charts of [Clopper 1934] and every text: 5 of 10 at 95 % is (0.1871, 0.8129).
  EXPECT_NEAR(clopper_pearson({.inside = 5, .total = 10}, 0.95).lower, 0.1871, 5e-5);
  EXPECT_NEAR(clopper_pearson({.inside = 5, .total = 10}, 0.95).upper, 0.8129, 5e-5);
}

TEST(Coverage, ClopperPearsonNeverCoversLessThanItSays) {
  // The exact coverage, summed over all outcomes.
  constexpr int kTrials = 40;
  for (const double p : {0.02, 0.3931, 0.6827, 0.9545, 0.9973}) {
    double covered = 0.0;
    double probability = std::pow(1.0 - p, kTrials);
    for (int inside = 0; inside <= kTrials; ++inside) {
      const ProportionInterval interval = clopper_pearson({.inside = inside, .total = kTrials}, 0.95);
      if (interval.lower <= p && p <= interval.upper) covered += probability;
      probability *= static_cast<double>(kTrials - inside) / (inside + 1.0) * p / (1.0 - p);
    }
    EXPECT_GE(covered, 0.95) << p;
  }
}

TEST(Coverage, BinomialPValueIsTheExactSum) {
  // 14 of 20 at ½: P(X ≥ 14) = 60460 / 2²⁰.
  EXPECT_NEAR(binomial_p_value({.inside = 14, .total = 20}, 0.5), 2.0 * 60460.0 / 1048576.0, 1e-12);
  EXPECT_NEAR(binomial_p_value({.inside = 6, .total = 20}, 0.5), 2.0 * 60460.0 / 1048576.0, 1e-12);
  EXPECT_EQ(binomial_p_value({.inside = 10, .total = 20}, 0.5), 1.0);
  EXPECT_NEAR(binomial_p_value({.inside = 0, .total = 20}, 0.5), 2.0 / 1048576.0, 1e-18);
  EXPECT_EQ(binomial_p_value({}, 0.5), 1.0);
}

CoverageVerdict study(double scale, int runs, std::size_t steps, double confidence,
                      std::mt19937_64& generator) {
  // Errors of a slow random walk: coverage strongly correlated in time.
  std::normal_distribution<double> normal;
  std::vector<CoverageCount> counts(steps);
  for (int run = 0; run < runs; ++run) {
    double error = normal(generator);
    for (CoverageCount& count : counts) {
      count.add(error * error * scale <= 4.0);
      error = 0.95 * error + std::sqrt(1.0 - 0.95 * 0.95) * normal(generator);
    }
  }
  return judge_coverage(counts, std::vector<double>(steps, expected_coverage(2.0, 1.0)), confidence);
}

TEST(Coverage, VerdictHoldsItsFalseAlarmRateUnderCorrelation) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(5);
  for (const double alpha : {0.05, 0.01}) {
    int alarms = 0;
    for (int i = 0; i < kStudies; ++i) {
      alarms += study(1.0, 50, 20, 1.0 - alpha, generator).verdict != Verdict::consistent;
    }
    EXPECT_LE(alarms, kStudies * (alpha + 5.0 * test::binomial_standard_error(alpha, kStudies)));
  }
}

TEST(Coverage, VerdictFindsBothDirections) {
  std::mt19937_64 generator(6);
  EXPECT_EQ(study(3.0, 200, 20, 0.95, generator).verdict, Verdict::optimistic);
  const CoverageVerdict wide = study(0.2, 400, 20, 0.95, generator);
  EXPECT_EQ(wide.verdict, Verdict::pessimistic);
  EXPECT_EQ(wide.tests, 20);
  EXPECT_GT(static_cast<double>(wide.pooled.inside) / static_cast<double>(wide.pooled.total), wide.expected);
}

TEST(Coverage, DegenerateAndImpossibleInput) {
  const CoverageVerdict none =
      judge_coverage(std::vector<CoverageCount>(3), std::vector<double>(3, 0.9), 0.95);
  EXPECT_EQ(none.verdict, Verdict::undecided);
  EXPECT_EQ(none.tests, 0);
  EXPECT_EQ(judge_coverage({}, {}, 0.95).verdict, Verdict::undecided);
  EXPECT_TRUE(std::isnan(clopper_pearson({}, 0.95).value));
  EXPECT_THROW(clopper_pearson({.inside = 3, .total = 2}, 0.95), std::invalid_argument);
  EXPECT_THROW(clopper_pearson({.inside = -1, .total = 2}, 0.95), std::invalid_argument);
  EXPECT_THROW(binomial_p_value({.inside = 1, .total = 2}, 1.5), std::invalid_argument);
  EXPECT_THROW(judge_coverage(std::vector<CoverageCount>(3), std::vector<double>(2, 0.9), 0.95),
               std::invalid_argument);
}

// Three tosses of a coin, and the upper tail of 12 of 20 at 0.3, 0.00513816 by its nine terms.
TEST(BinomialUpperTail, IsExact) {
  EXPECT_EQ(binomial_upper_tail(0, 3, 0.5), 1.0);
  EXPECT_DOUBLE_EQ(binomial_upper_tail(2, 3, 0.5), 0.5);
  EXPECT_DOUBLE_EQ(binomial_upper_tail(3, 3, 0.5), 0.125);
  EXPECT_NEAR(binomial_upper_tail(12, 20, 0.3), 0.00513816, 5e-9);
}

}  // namespace
}  // namespace credence::internal
