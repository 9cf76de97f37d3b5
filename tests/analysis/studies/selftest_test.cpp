#include "analysis/studies/selftest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "analysis/studies/selftest_study.h"

namespace credence {
namespace {

CalibrationRow row(Exactness exactness, double nominal, std::int64_t rejected) {
  return {"test", exactness, nominal, {.count = {.inside = rejected, .total = 2000}}};
}

TEST(Selftest, ExactFilterHasTheMeansOfItsLaws) {
  const SyntheticFilter filter({});
  const SyntheticStudy study = make_study(filter, NoiseSource(3, 7), 0, 40);
  // Over 1280 runs; at one step, χ²(2) has standard deviation 2.
  const double error = 2.0 / std::sqrt(1280.0);
  for (const std::size_t k : {0U, 5U, 39U}) {
    EXPECT_NEAR(study.nees[k].mean, 2.0, 5.0 * error) << k;
    EXPECT_NEAR(study.nis[k].mean, 2.0, 5.0 * error) << k;
    EXPECT_NEAR(study.heading_nees[k].mean, 1.0, 5.0 * error) << k;
    EXPECT_NEAR(study.landmark_nees[k].mean, 1.0, 5.0 * error) << k;
  }
  EXPECT_EQ(study.beyond_half_turn, 0);
  EXPECT_EQ(study.last_errors.size(), 1280U);
}

TEST(Selftest, DefectsDoWhatTheySay) {
  const NoiseSource noise(3, 7);
  const auto study = [&](Defect defect) {
    return make_study(SyntheticFilter(setup_of(defect)), noise, 0, 4);
  };
  EXPECT_GT(study(Defect::unwrapped_angle).beyond_half_turn, 0);
  EXPECT_GT(study(Defect::initial_covariance).nis[0].mean, 4.0);
  EXPECT_GT(study(Defect::measurement_noise_too_small).nis[39].mean, 2.5);
  EXPECT_LT(study(Defect::process_noise_too_large).nis[39].mean, 1.5);
  const SyntheticStudy gated = study(Defect::gated_innovations);
  EXPECT_EQ(gated.nis_values.size(), gated.gated_nis_values.size());
  EXPECT_LT(gated.nis_values.size(), 4U * 32U * 40U);
  EXPECT_EQ(SyntheticFilter(setup_of(Defect::wrong_dof)).judged_dof(), 3.0);
}

TEST(Selftest, NaiveTimeSumIsWrongByMuch) {
  // The reason for all of it: the variance of the NEES sum is many times that of independent steps.
  const SyntheticFilter filter({});
  const NeesTimeLaw law = battery_laws(filter, SyntheticFilter::kRuns).time_law;
  EXPECT_GT(law.run_sum.variance / (4.0 * SyntheticFilter::kSteps), 10.0);
  const SyntheticStudy study = make_study(filter, NoiseSource(3, 8), 0, 40);
  EXPECT_NEAR(study.run_sum_nees.variance() / law.run_sum.variance, 1.0, 0.5);
}

TEST(Selftest, RowsFailWhenTheyShould) {
  SelftestResult result;
  result.calibration = {row(Exactness::exact, 0.05, 100),        row(Exactness::exact, 0.05, 160),
                        row(Exactness::exact, 0.05, 50),         row(Exactness::conservative, 0.05, 0),
                        row(Exactness::conservative, 0.05, 160), row(Exactness::approximate, 0.01, 60)};
  judge_selftest(result);
  const bool expected[] = {true, false, false, true, false, false};
  for (std::size_t i = 0; i < result.calibration.size(); ++i) {
    EXPECT_EQ(result.calibration[i].ok, expected[i]) << i;
  }
  EXPECT_FALSE(result.ok);

  result.calibration.resize(1);
  judge_selftest(result);
  EXPECT_TRUE(result.ok);
  // A wrong filter that half of the studies miss.
  result.wrong_filters.resize(1);
  result.wrong_filters[0].caught = {.count = {.inside = 100, .total = 200}};
  result.wrong_filters[0].named = {.count = {.inside = 200, .total = 200}};
  result.wrong_filters[0].caught_wanted = result.wrong_filters[0].named_wanted = 0.9;
  judge_selftest(result);
  EXPECT_FALSE(result.ok);
}

TEST(Selftest, FamilyLevelIsThatOfAllRows) {
  // Clopper and Pearson at 1 − γ fail a row of 2000 studies with at most γ: 80 rows stay below 0.1 %.
  SelftestResult result;
  result.calibration.assign(80, row(Exactness::exact, 0.05, 100));
  judge_selftest(result);
  EXPECT_NEAR((1.0 - result.interval_confidence) * 80.0, result.family_level, 1e-12);
}

void expect_same(const StudyShare& a, const StudyShare& b) { EXPECT_EQ(a.count, b.count); }

TEST(Selftest, SameForAnyNumberOfThreads) {
  SelftestOptions options{.studies = 100, .seed = 5, .threads = 1};
  std::int64_t last = 0, all = 0;
  options.progress = [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(done, last + 1);
    last = done;
    all = total;
  };
  const SelftestResult one = run_selftest(options);
  EXPECT_EQ(last, all);
  options.threads = 3;
  options.progress = {};
  const SelftestResult three = run_selftest(options);
  ASSERT_TRUE(one.complete && three.complete);
  ASSERT_EQ(one.calibration.size(), three.calibration.size());
  EXPECT_GT(one.calibration.size(), 60U);
  for (std::size_t i = 0; i < one.calibration.size(); ++i) {
    SCOPED_TRACE(one.calibration[i].name);
    expect_same(one.calibration[i].measured, three.calibration[i].measured);
  }
  ASSERT_EQ(one.wrong_filters.size(), 11U);
  for (std::size_t i = 0; i < one.wrong_filters.size(); ++i) {
    expect_same(one.wrong_filters[i].caught, three.wrong_filters[i].caught);
    expect_same(one.wrong_filters[i].named, three.wrong_filters[i].named);
  }
  for (std::size_t i = 0; i < one.savings.size(); ++i) {
    EXPECT_EQ(one.savings[i].runs.mean, three.savings[i].runs.mean);
  }
}

TEST(Selftest, StopsWhenAsked) {
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(run_selftest({.studies = 100, .stop = &stop, .progress = {}}).complete);
  EXPECT_THROW(run_selftest({.studies = 99, .progress = {}}), std::invalid_argument);
  EXPECT_THROW(run_selftest({.threads = -1, .progress = {}}), std::invalid_argument);
}

}  // namespace
}  // namespace credence
