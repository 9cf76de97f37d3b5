#include "analysis/studies/selftest_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/studies/selftest_families.h"
#include "analysis/studies/selftest_study.h"
#include "analysis/studies/selftest_tests.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kFewStudies = 24;
constexpr std::uint64_t kCalibrationSeed = 8;

/// Calibrated, with the work that was done.
struct Calibrated {
  SelftestResult result;
  std::int64_t done = 0;
};

Calibrated few_studies() {
  Calibrated c;
  SelftestOptions options{.studies = kFewStudies, .seed = kCalibrationSeed, .threads = 2};
  options.progress = [&](std::int64_t done, std::int64_t) { c.done = done; };
  SelftestWorkers workers(options, calibration_work(options));
  calibrate(options, workers, c.result);
  judge_selftest(c.result);
  return c;
}

const CalibrationRow& row_of(const SelftestResult& result, const std::string& name, double level) {
  const auto found = std::ranges::find_if(result.calibration, [&](const CalibrationRow& row) {
    return row.name == name && row.nominal == level;
  });
  if (found == result.calibration.end()) throw std::out_of_range(name);
  return *found;
}

// Five parts of `studies` items; the word's ten, of 50 runs half and of 200 a quarter of them; and four
// blocks of 32 long runs for every 32 studies.
TEST(SelftestCalibration, ItsWorkIsWhatItSays) {
  EXPECT_EQ(calibration_work({.studies = 100}), 5 * 100 + (8 * 100 + 50 + 25) + 3 * 25 + 4 * 4);
  EXPECT_EQ(calibration_work({.studies = 2000}), 5 * 2000 + (8 * 2000 + 1000 + 500) + 3 * 500 + 4 * 63);
}

void expect_rows_at_both_levels(const SelftestResult& result) {
  std::map<std::string, std::map<double, CoverageCount>> rows;
  for (const CalibrationRow& row : result.calibration) {
    EXPECT_TRUE(rows[row.name].emplace(row.nominal, row.measured.count).second) << row.name;
  }
  for (const auto& [name, counts] : rows) {
    ASSERT_EQ(counts.size(), 2U) << name;
    const CoverageCount &often = counts.at(0.05), &seldom = counts.at(0.01);
    EXPECT_EQ(often.total, seldom.total) << name;
    EXPECT_LE(seldom.inside, often.inside) << name;
    const bool compared = name.starts_with("change of any") || name.starts_with("any estimator") ||
                          name.starts_with("paired difference") || name.ends_with("of tuning") ||
                          name.ends_with("a tuned factor");
    const std::int64_t studies = name.starts_with("the word, 50 runs")    ? kFewStudies / 2
                                 : name.starts_with("the word, 200 runs") ? kFewStudies / 4
                                 : compared                               ? kFewStudies / 4
                                 : name.find("of one long") != name.npos  ? SyntheticFilter::kRuns
                                 : name.starts_with("agreement of")       ? SyntheticFilter::kRuns / 4
                                                                          : kFewStudies;
    EXPECT_EQ(often.total, studies) << name;
  }
}

// The same tests, first where P is that of all runs.
void expect_shipped_tests_twice(const SelftestResult& result) {
  std::set<std::string> names;
  for (const CalibrationRow& row : result.calibration) names.insert(row.name);
  const std::string many = ", P differs between runs";
  int pairs = 0;
  for (const std::string& name : names) {
    if (!name.ends_with(many)) continue;
    EXPECT_TRUE(names.contains(name.substr(0, name.size() - many.size()))) << name;
    ++pairs;
  }
  EXPECT_GT(pairs, 10);
  EXPECT_TRUE(names.contains("the word" + many));
}

// Each row with an interval in which its level lies, at a confidence at which one row in a thousand
// selftests fails.
void expect_rates_of_the_levels(const SelftestResult& result) {
  for (const CalibrationRow& row : result.calibration) {
    EXPECT_TRUE(row.ok) << row.name << " at " << row.nominal << ": " << row.measured.count.inside << " of "
                        << row.measured.count.total;
  }
}

// The variance of the runs' sums is more than ten times that of χ² (selftest_test.cpp), so that more than
// half of the studies lie beyond its bounds; and one of forty steps outside its 95 % in 1 − 0.95⁴⁰ = 87 %.
void expect_naive_rates_far_above(const SelftestResult& result) {
  const std::vector<NaiveRow>& naive = result.naive;
  ASSERT_EQ(naive.size(), 3U);
  for (const NaiveRow& row : naive) {
    EXPECT_EQ(row.nominal, 0.05) << row.name;
    EXPECT_NO_THROW(row_of(result, row.instead, 0.05)) << row.name;
  }
  for (const NaiveRow& row : std::span(naive).first(2)) {
    EXPECT_GT(row.measured.interval.lower, 0.05) << row.name;
    EXPECT_GT(row.measured.count.inside, row_of(result, row.instead, 0.05).measured.count.inside) << row.name;
  }
  const SyntheticFilter exact({});
  std::int64_t rejected = 0;
  for (std::int64_t i = 0; i < kFewStudies / 4; ++i) {
    const NoiseSource noise(kCalibrationSeed, SelftestNoise::kLooks);
    rejected += naive_looks_reject(exact, noise, i, 0.95) ? 1 : 0;
  }
  EXPECT_EQ(naive[2].measured.count, (CoverageCount{.inside = rejected, .total = kFewStudies / 4}));
}

// The studies made again, one by one: block i is that of study i.
void expect_alarms_of_its_studies(const SelftestResult& result) {
  const SyntheticFilter exact({});
  const NoiseSource noise(kCalibrationSeed, SelftestNoise::kTests);
  std::map<std::string, std::int64_t> alarms;
  std::int64_t all = 0;
  for (std::int64_t i = 0; i < kFewStudies; ++i) {
    CalibrationRecorder recorder;
    const Evidence evidence =
        synthetic_evidence(exact, noise, i, SyntheticFilter::kRuns, SyntheticFilter::kSteps, &recorder);
    const auto [calibration, judgement] = judge_rows(evidence, recorder, 0.95);
    for (const TestResult& test : shipped_tests(evidence, judgement, calibration)) {
      alarms[test.name] += test.p_value <= 0.05 ? 1 : 0;
      all += test.p_value <= 0.05 ? 1 : 0;
    }
  }
  for (const auto& [name, count] : alarms) {
    EXPECT_EQ(row_of(result, name, 0.05).measured.count.inside, count) << name;
  }
  EXPECT_GT(all, 10) << "or nothing is compared";
}

void expect_the_word_of_its_studies(const SelftestResult& result) {
  const SyntheticFilter exact({});
  const NoiseSource noise(kCalibrationSeed, SelftestNoise::kWord + 2);
  std::map<double, std::int64_t> alarms;
  for (std::int64_t i = 0; i < kFewStudies; ++i) {
    const double p = judge(synthetic_evidence(exact, noise, i, 5), {.confidence = 0.95}).word.p_value;
    for (const double level : {0.05, 0.01}) alarms[level] += p <= level ? 1 : 0;
  }
  for (const double level : {0.05, 0.01}) {
    EXPECT_EQ(row_of(result, "the word, 5 runs", level).measured.count.inside, alarms[level]) << level;
  }
  EXPECT_EQ(row_of(result, "the word, 1 run", 0.05).exactness, Exactness::conservative);
}

void expect_sweeps_and_single_runs_of_the_families(const SelftestResult& result) {
  const SyntheticSweep sweep;
  const double levels[] = {0.05};
  std::int64_t any = 0, drawn = 0, single = 0;
  for (std::int64_t i = 0; i < kFewStudies; ++i) {
    const auto found = sweep.discoveries(NoiseSource(kCalibrationSeed, SelftestNoise::kSweep), i, levels);
    any += found[0].any_false;
    drawn += found[0].drawn_is_false;
  }
  for (const double p : single_run_p_values(NoiseSource(kCalibrationSeed, SelftestNoise::kSingleRuns), 0)) {
    single += p <= 0.05 ? 1 : 0;
  }
  EXPECT_EQ(row_of(result, "sweep of 12 exact filters, any discovery", 0.05).measured.count.inside, any);
  EXPECT_EQ(row_of(result, "sweep of 8 exact and 4 wrong filters, false discovery rate", 0.05)
                .measured.count.inside,
            drawn);
  EXPECT_EQ(row_of(result, "NEES of one long run, effective sample size", 0.05).measured.count.inside,
            single);
}

// In one test, as it takes a while.
TEST(SelftestCalibration, CountsHowOftenExactFiltersAreAccused) {
  const Calibrated c = few_studies();
  EXPECT_EQ(c.done, calibration_work({.studies = kFewStudies}));
  expect_rows_at_both_levels(c.result);
  expect_shipped_tests_twice(c.result);
  expect_rates_of_the_levels(c.result);
  expect_naive_rates_far_above(c.result);
  expect_alarms_of_its_studies(c.result);
  expect_the_word_of_its_studies(c.result);
  expect_sweeps_and_single_runs_of_the_families(c.result);
}

}  // namespace
}  // namespace credence::internal
