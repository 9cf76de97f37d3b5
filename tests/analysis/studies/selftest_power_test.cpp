#include "analysis/studies/selftest_power.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/studies/selftest_families.h"
#include "analysis/studies/selftest_study.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kPowerSeed = 9;

struct MeasuredPower {
  SelftestResult result;
  std::int64_t done = 0;
};

/// Ten studies of each wrong filter and five that stop.
MeasuredPower measured_power() {
  MeasuredPower m;
  SelftestOptions options{.studies = 100, .seed = kPowerSeed, .threads = 2};
  options.progress = [&](std::int64_t done, std::int64_t) { m.done = done; };
  SelftestWorkers workers(options, power_work(options));
  measure_power(options, workers, m.result);
  judge_selftest(m.result);
  return m;
}

const WrongFilterResult& wrong_filter_of(const SelftestResult& result, Defect defect) {
  const auto& all = result.wrong_filters;
  const auto found = std::ranges::find(all, to_string(defect), &WrongFilterResult::name);
  if (found == all.end()) throw std::out_of_range(std::string(to_string(defect)));
  return *found;
}

// Thirteen defects with a tenth of the studies, four of them with a twentieth that stop.
TEST(SelftestPower, ItsWorkIsWhatItSays) {
  EXPECT_EQ(power_work({.studies = 2000}), 13 * 200 + 4 * 100);
  EXPECT_EQ(power_work({.studies = 199}), 13 * 19 + 4 * 9);
}

void expect_every_defect_once(const SelftestResult& result) {
  std::set<std::string> tried;
  for (const WrongFilterResult& wrong : result.wrong_filters) {
    EXPECT_TRUE(tried.insert(wrong.name).second) << wrong.name;
    EXPECT_EQ(wrong.named_wanted, 0.8) << wrong.name;
    ASSERT_FALSE(wrong.power.empty()) << wrong.name;
    for (const PowerRow& row : wrong.power) EXPECT_EQ(row.measured.count.total, 10) << row.test;
  }
  for (int i = 1; i <= static_cast<int>(Defect::shared_prior); ++i) {
    EXPECT_TRUE(tried.contains(std::string(to_string(static_cast<Defect>(i))))) << i;
  }
  EXPECT_EQ(tried.size(), 13U);
}

// One whose covariance is right must not be accused; every other must be found, and its cause named.
void expect_wrong_filters_found_and_named(const SelftestResult& result) {
  for (const WrongFilterResult& wrong : result.wrong_filters) {
    EXPECT_TRUE(wrong.ok) << wrong.name << ": caught " << wrong.caught.count.inside << ", named "
                          << wrong.named.count.inside;
    const bool right = wrong.name == to_string(Defect::gated_innovations) ||
                       wrong.name == to_string(Defect::heavy_tails) ||
                       wrong.name == to_string(Defect::shared_prior);
    EXPECT_EQ(wrong.caught_wanted, right ? 0.0 : 0.95) << wrong.name;
    EXPECT_EQ(wrong.caught_most, right ? 0.1 : 1.0) << wrong.name;
  }
}

void expect_directions_of_the_noise(const SelftestResult& result) {
  EXPECT_EQ(wrong_filter_of(result, Defect::measurement_noise_too_small).direction, Verdict::optimistic);
  EXPECT_EQ(wrong_filter_of(result, Defect::process_noise_too_large).direction, Verdict::pessimistic);
  EXPECT_EQ(wrong_filter_of(result, Defect::wrong_dof).direction, Verdict::pessimistic)
      << "a state without an error";
  EXPECT_FALSE(wrong_filter_of(result, Defect::biased_measurement).direction.has_value());
  for (const WrongFilterResult& wrong : result.wrong_filters) {
    if (!wrong.direction) continue;
    EXPECT_EQ(wrong.direction_right.count.total, wrong.caught.count.inside) << wrong.name;
    EXPECT_GE(wrong.direction_right.count.inside, wrong.caught.count.inside - 1) << wrong.name;
  }
}

void expect_sorted_shares_of_causes(const SelftestResult& result) {
  for (const WrongFilterResult& wrong : result.wrong_filters) {
    EXPECT_TRUE(std::ranges::is_sorted(wrong.causes, std::ranges::greater{}, &CauseShare::share));
    const double sum = std::accumulate(wrong.causes.begin(), wrong.causes.end(), 0.0,
                                       [](double all, const CauseShare& c) { return all + c.share; });
    EXPECT_LE(sum, 1.0 + 1e-12) << wrong.name;
    ASSERT_FALSE(wrong.causes.empty()) << wrong.name;
    EXPECT_EQ(wrong.causes.front().cause, wrong.expected) << wrong.name;
    EXPECT_DOUBLE_EQ(10.0 * wrong.causes.front().share, static_cast<double>(wrong.named.count.inside));
  }
}

// Studies made again, one by one: study i has the four blocks from 4 i on.
void expect_counts_of_its_studies(const SelftestResult& result) {
  constexpr Defect kDefect = Defect::coloured_noise;
  const SyntheticFilter filter(setup_of(kDefect));
  const NoiseSource noise(kPowerSeed, SelftestNoise::kWrong + static_cast<std::uint64_t>(kDefect));
  std::int64_t caught = 0, named = 0;
  for (std::int64_t i = 0; i < 10; ++i) {
    const Judgement judgement =
        judge(synthetic_evidence(filter, noise, 4 * i, 4 * SyntheticFilter::kRuns), {.confidence = 0.95});
    caught += is_inconsistent(judgement.word.verdict) ? 1 : 0;
    named += !judgement.causes.empty() && judgement.causes.front().cause == Cause::coloured_noise ? 1 : 0;
  }
  EXPECT_EQ(wrong_filter_of(result, kDefect).caught.count.inside, caught);
  EXPECT_EQ(wrong_filter_of(result, kDefect).named.count.inside, named);
}

void expect_savings_on_what_is_clearly_wrong(const SelftestResult& result) {
  const std::vector<SavingResult>& savings = result.savings;
  ASSERT_EQ(savings.size(), 4U);
  EXPECT_EQ(savings[2].name, to_string(Defect::measurement_noise_too_small));
  for (const SavingResult& saving : savings) {
    EXPECT_EQ(saving.max_runs, kSequentialChunks * SyntheticFilter::kRuns);
    EXPECT_EQ(saving.caught.count, (CoverageCount{.inside = 5, .total = 5})) << saving.name;
    EXPECT_LT(saving.runs.mean, 0.5 * static_cast<double>(saving.max_runs)) << saving.name;
  }
  const SyntheticFilter filter(setup_of(Defect::measurement_noise_too_small));
  const StopRule rule{.confidence = 0.95};
  const NoiseSource noise(
      kPowerSeed, SelftestNoise::kSavings + static_cast<std::uint64_t>(Defect::measurement_noise_too_small));
  double runs = 0.0;
  for (std::int64_t i = 0; i < 5; ++i) {
    runs += static_cast<double>(sequential_outcomes(filter, {&rule, 1}, noise, i).front().runs);
  }
  EXPECT_NEAR(savings[2].runs.mean, runs / 5.0, 1e-9);
}

// In one test, as it takes a while.
TEST(SelftestPower, CountsHowOftenWrongFiltersAreFound) {
  const MeasuredPower m = measured_power();
  EXPECT_EQ(m.done, power_work({.studies = 100}));
  EXPECT_EQ(m.result.wrong_filter_studies, 10);
  EXPECT_EQ(m.result.wrong_filter_runs, 4 * SyntheticFilter::kRuns);
  expect_every_defect_once(m.result);
  expect_wrong_filters_found_and_named(m.result);
  expect_directions_of_the_noise(m.result);
  expect_sorted_shares_of_causes(m.result);
  expect_counts_of_its_studies(m.result);
  expect_savings_on_what_is_clearly_wrong(m.result);
}

}  // namespace
}  // namespace credence::internal
