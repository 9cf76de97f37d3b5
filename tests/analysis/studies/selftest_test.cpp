#include "analysis/studies/selftest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "analysis/laws/mean/effective_sample.h"
#include "analysis/studies/selftest_study.h"
#include "montecarlo/engine/shared_tasks.h"
#include "tests/montecarlo/engine/thread_ranks.h"

namespace credence::internal {
namespace {

CalibrationRow row(Exactness exactness, double nominal, std::int64_t rejected) {
  return {"test", exactness, nominal, {.count = {.inside = rejected, .total = 2000}}};
}

TEST(Selftest, ExactFilterHasTheMeansOfItsLaws) {
  const Evidence e = synthetic_evidence(SyntheticFilter({}), NoiseSource(3, 7), 0, 1280);
  EXPECT_EQ(e.study.runs, 1280);
  // At one step, χ²(2) has standard deviation 2.
  const double error = 2.0 / std::sqrt(1280.0);
  for (const std::size_t k : {0U, 5U, 39U}) {
    EXPECT_NEAR(e.study.steps[k][Quantity::nees].mean, 2.0, 5.0 * error) << k;
    EXPECT_NEAR(e.study.steps[k][Quantity::nis].mean, 2.0, 5.0 * error) << k;
    EXPECT_NEAR(e.blocks[0].nees[k].value.mean, 1.0, 5.0 * error) << k;
    EXPECT_NEAR(e.blocks[1].nees[k].value.mean, 1.0, 5.0 * error) << k;
  }
  EXPECT_EQ(e.sensors[0].unwrapped, 0);
  EXPECT_EQ(e.whole_runs.last_error.size(), 1024U);
}

TEST(Selftest, DefectsDoWhatTheySay) {
  const NoiseSource noise(3, 7);
  const auto evidence = [&](Defect defect) {
    return synthetic_evidence(SyntheticFilter(setup_of(defect)), noise, 0, 128);
  };
  EXPECT_GT(evidence(Defect::unwrapped_angle).sensors[0].unwrapped, 0);
  EXPECT_GT(evidence(Defect::initial_covariance).study.steps[0][Quantity::nis].mean, 4.0);
  EXPECT_GT(evidence(Defect::measurement_noise_too_small).study.steps[39][Quantity::nis].mean, 2.5);
  EXPECT_LT(evidence(Defect::process_noise_too_large).study.steps[39][Quantity::nis].mean, 1.5);
  EXPECT_LT(evidence(Defect::gated_innovations).sensors[0].fit.count(), 128 * 40);
  EXPECT_EQ(judge(evidence(Defect::wrong_dof)).nees.expected, 3.0);
}

TEST(Selftest, NaiveTimeSumIsWrongByMuch) {
  // The reason for all of it: the variance of the NEES sum is many times that of independent steps.
  const SyntheticFilter filter({});
  const double independent = 4.0 * SyntheticFilter::kSteps;
  const double variance = independent * SyntheticFilter::kSteps /
                          linear_run_law(filter.transitions(), filter.covariances()).effective_steps;
  EXPECT_GT(variance / independent, 10.0);
  const Evidence e = synthetic_evidence(filter, NoiseSource(3, 8), 0, 1280);
  const double dof = SyntheticFilter::kStateDof * SyntheticFilter::kSteps;
  EXPECT_NEAR(e.study.nees_of_runs.moments.variance() * dof * dof / variance, 1.0, 0.5);
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

TEST(Selftest, SameForAnyNumberOfThreadsAndRanks) {
  SelftestOptions options{.studies = 100, .seed = 5, .threads = 1};
  std::int64_t last = 0, all = 0;
  options.progress = [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(done, last + 1);
    last = done;
    all = total;
  };
  const SelftestResult one = run_selftest(options);
  EXPECT_EQ(last, all);
  SelftestResult shared;
  on_ranks(2, [&](ThreadRanks& ranks) {
    try {
      const SelftestResult result =
          run_selftest({.studies = 100, .seed = 5, .threads = 2, .progress = {}, .ranks = &ranks});
      if (is_helper(&ranks)) {
        EXPECT_FALSE(result.complete);
      } else {
        shared = result;
      }
    } catch (const RanksEnded&) {
      EXPECT_TRUE(is_helper(&ranks));
    }
    finish_ranks(ranks);
  });
  ASSERT_TRUE(one.complete && shared.complete);
  ASSERT_EQ(one.calibration.size(), shared.calibration.size());
  EXPECT_GT(one.calibration.size(), 45U);
  for (std::size_t i = 0; i < one.calibration.size(); ++i) {
    SCOPED_TRACE(one.calibration[i].name);
    expect_same(one.calibration[i].measured, shared.calibration[i].measured);
  }
  ASSERT_EQ(one.wrong_filters.size(), 13U);
  for (std::size_t i = 0; i < one.wrong_filters.size(); ++i) {
    expect_same(one.wrong_filters[i].caught, shared.wrong_filters[i].caught);
    expect_same(one.wrong_filters[i].named, shared.wrong_filters[i].named);
  }
  for (std::size_t i = 0; i < one.savings.size(); ++i) {
    EXPECT_EQ(one.savings[i].runs.mean, shared.savings[i].runs.mean);
  }
}

TEST(Selftest, StopsWhenAsked) {
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(run_selftest({.studies = 100, .stop = &stop, .progress = {}}).complete);
  EXPECT_THROW(run_selftest({.studies = 99, .progress = {}}), std::invalid_argument);
  EXPECT_THROW(run_selftest({.threads = -1, .progress = {}}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
