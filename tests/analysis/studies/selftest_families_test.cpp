#include "analysis/studies/selftest_families.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace credence::internal {
namespace {

constexpr std::int64_t kMostRuns = std::int64_t{kSequentialChunks} * SyntheticFilter::kRuns;

/// Five standard errors of a share.
double five_errors(double share, int count) { return 5.0 * std::sqrt(share * (1.0 - share) / count); }

TEST(SelftestFamilies, EveryRuleStopsAsItWouldAlone) {
  const StopRule rules[] = {{.confidence = 0.95},
                            {.confidence = 0.999},
                            {.confidence = 0.95, .on_verdict = false, .precision = 0.1},
                            {.confidence = 0.95, .on_verdict = false}};
  for (const Defect defect : {Defect::none, Defect::measurement_noise_too_small}) {
    const SyntheticFilter filter(setup_of(defect));
    for (const std::int64_t index : {0, 3}) {
      const NoiseSource noise(11, 5);
      const auto together = sequential_outcomes(filter, rules, noise, index);
      ASSERT_EQ(together.size(), std::size(rules));
      for (std::size_t i = 0; i < std::size(rules); ++i) {
        const SequentialOutcome alone = sequential_outcomes(filter, {&rules[i], 1}, noise, index).front();
        EXPECT_EQ(together[i].runs, alone.runs) << i;
        EXPECT_EQ(together[i].verdict, alone.verdict) << i;
        EXPECT_EQ(together[i].mean_nees.mean, alone.mean_nees.mean) << i;
        EXPECT_EQ(together[i].runs % SyntheticFilter::kRuns, 0) << "looks are after chunks";
      }
      EXPECT_LE(together[0].runs, together[1].runs) << "more confidence needs more runs";
      EXPECT_EQ(together[3].runs, kMostRuns) << "a rule that never stops ends with the study";
    }
  }
}

// Of studies that shared runs the means would follow each other.
TEST(SelftestFamilies, StudiesHaveNoRunsInCommon) {
  constexpr int kStudies = 60;
  const SyntheticFilter filter({});
  const StopRule never{.on_verdict = false};
  std::vector<double> off;
  for (int i = 0; i < kStudies; ++i) {
    off.push_back(sequential_outcomes(filter, {&never, 1}, NoiseSource(16, 6), i).front().mean_nees.mean -
                  SyntheticFilter::kStateDof);
  }
  double together = 0.0, alone = off[0] * off[0];
  for (std::size_t i = 1; i < off.size(); ++i) {
    together += off[i - 1] * off[i];
    alone += off[i] * off[i];
  }
  EXPECT_LT(std::abs(together / alone), 5.0 / std::sqrt(kStudies));
}

TEST(SelftestFamilies, AWrongFilterStopsEarlyAndOptimistic) {
  const SyntheticFilter filter(setup_of(Defect::measurement_noise_too_small));
  const StopRule rule{.confidence = 0.95};
  for (std::int64_t index = 0; index < 10; ++index) {
    const SequentialOutcome outcome =
        sequential_outcomes(filter, {&rule, 1}, NoiseSource(12, 1), index).front();
    EXPECT_EQ(outcome.verdict, Verdict::optimistic) << index;
    EXPECT_LT(outcome.runs, kMostRuns) << index;
  }
}

TEST(SelftestFamilies, LookingOftenAtAFixedTestRejectsFarTooOften) {
  constexpr int kStudies = 200;
  constexpr double kLevel = 0.05;
  const SyntheticFilter exact({});
  const NoiseSource noise(13, 2);
  const StopRule rule{.confidence = 1.0 - kLevel};
  int naive = 0, sequential = 0;
  for (int i = 0; i < kStudies; ++i) {
    naive += naive_looks_reject(exact, noise, i, 1.0 - kLevel);
    sequential += is_inconsistent(sequential_outcomes(exact, {&rule, 1}, noise, i).front().verdict);
  }
  EXPECT_GT(naive, kStudies * (kLevel + five_errors(kLevel, kStudies)));
  EXPECT_LE(sequential, kStudies * (kLevel + five_errors(kLevel, kStudies)));
}

TEST(SelftestFamilies, DiscoveriesAreNoneAtNoLevelAndAllAtLevelOne) {
  const SyntheticSweep sweep;
  const NoiseSource noise(14, 3);
  const double levels[] = {0.0, 0.05, 0.3, 1.0};
  constexpr int kStudies = 300;
  int drawn_false = 0, false_at_level = 0;
  for (int i = 0; i < kStudies; ++i) {
    const auto at = sweep.discoveries(noise, i, levels);
    ASSERT_EQ(at.size(), 4U);
    EXPECT_FALSE(at[0].any_false || at[0].drawn_is_false);
    EXPECT_TRUE(at[3].any_false);
    EXPECT_LE(at[1].any_false, at[2].any_false) << "what is found at a level is found at a higher one";
    drawn_false += at[3].drawn_is_false;
    false_at_level += at[1].any_false;
  }
  // All twelve are discovered, of which eight are exact.
  constexpr double kFalse =
      static_cast<double>(SyntheticSweep::kExact) / (SyntheticSweep::kExact + SyntheticSweep::kWrong);
  EXPECT_NEAR(drawn_false, kStudies * kFalse, kStudies * five_errors(kFalse, kStudies));
  EXPECT_LE(false_at_level, kStudies * (0.05 + five_errors(0.05, kStudies)));
}

std::vector<double> sorted_p_values(std::array<double, SyntheticFilter::kRuns> (*of_block)(const NoiseSource&,
                                                                                           std::int64_t)) {
  const NoiseSource noise(15, 4);
  std::vector<double> p_values;
  for (std::int64_t block = 0; block < 40; ++block) {
    for (const double p : of_block(noise, block)) {
      if (!std::isnan(p)) p_values.push_back(p);
    }
  }
  std::ranges::sort(p_values);
  return p_values;
}

TEST(SelftestFamilies, SingleRunsHaveUniformPValues) {
  const std::vector<double> p_values = sorted_p_values(single_run_p_values);
  EXPECT_EQ(std::ranges::adjacent_find(p_values), p_values.end()) << "every run is one of its own";
  // A test by effective rows is approximate: half as much again is allowed.
  const auto count = static_cast<int>(p_values.size());
  for (const double level : {0.1, 0.25, 0.5, 0.75}) {
    const auto below = std::ranges::lower_bound(p_values, level) - p_values.begin();
    EXPECT_NEAR(static_cast<double>(below), count * level, count * 1.5 * five_errors(level, count)) << level;
  }
}

TEST(SelftestFamilies, TheSizeOfOneRunOverTimeHoldsItsLevel) {
  const std::vector<double> nis = sorted_p_values(nis_over_time_p_values);
  const std::vector<double> nees = sorted_p_values(nees_over_time_p_values);
  const auto count = static_cast<int>(nis.size());
  EXPECT_GT(std::ssize(nees), count / 2) << "of many the test is made";
  for (const double level : {0.05, 0.01}) {
    const auto below = std::ranges::upper_bound(nis, level) - nis.begin();
    EXPECT_NEAR(static_cast<double>(below), count * level, count * five_errors(level, count)) << level;
    const auto bounded = std::ranges::upper_bound(nees, level) - nees.begin();
    EXPECT_LE(static_cast<double>(bounded), count * (level + five_errors(level, count))) << level;
  }
}

// 1,500 studies: Bonferroni over four logs.
TEST(SelftestFamilies, AgreementOfOffsetsHoldsItsLevel) {
  const NoiseSource noise(16, 4);
  int below = 0, smaller = 0, count = 0;
  for (std::int64_t block = 0; block < 94; ++block) {
    for (const double p : agreement_p_values(noise, block)) {
      ASSERT_FALSE(std::isnan(p));
      below += p <= 0.05;
      smaller += p <= 0.5;
      ++count;
    }
  }
  EXPECT_LE(below, count * (0.05 + five_errors(0.05, count)));
  EXPECT_GT(smaller, count / 20) << "it is no test that never rejects";
}

}  // namespace
}  // namespace credence::internal
