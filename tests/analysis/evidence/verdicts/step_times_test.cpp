#include "analysis/evidence/verdicts/step_times.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/evidence/sums/step_series.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

StepTimes run_at(double begin_s, double interval_s, std::int64_t steps) {
  StepTimes times;
  times.begin_run();
  for (std::int64_t k = 0; k < steps; ++k) times.add(k + 1, begin_s + interval_s * static_cast<double>(k));
  return times;
}

TEST(StepTimes, NothingIsKnownOfRunsWithoutTimes) {
  StepTimes times;
  times.begin_run();
  times.add(1, kNaN);
  times.add(2, kNaN);
  EXPECT_FALSE(times.known());
  EXPECT_TRUE(std::isnan(times.at(1)));
  EXPECT_EQ(times.text(1, 2), "");
}

TEST(StepTimes, OfSimulatedRunsAreMultiplesOfAStepHoweverLong) {
  EXPECT_EQ(StepTimes::every(0.0), nullptr);
  const auto times = StepTimes::every(0.25);
  EXPECT_TRUE(times->known() && times->as_told());
  EXPECT_EQ(times->at(4 * kMostSteps + 3), 0.25 * static_cast<double>(4 * kMostSteps + 3));
  EXPECT_EQ(times->text(188, 188), " (t = 47.00 s)");
  EXPECT_EQ(times->text(1, 3), " (t = 0.25 to 0.75 s)");
}

TEST(StepTimes, AreToldAsTheRunsTellThemInTheDigitsOfAStep) {
  const StepTimes times = run_at(0.1, 0.1, 200);
  EXPECT_TRUE(times.as_told());
  EXPECT_DOUBLE_EQ(times.at(188), 18.8);
  EXPECT_EQ(times.text(188, 188), " (t = 18.8 s)");
  EXPECT_EQ(times.text(3, 7), " (t = 0.3 to 0.7 s)");
  EXPECT_EQ(run_at(0.0, 0.005, 10).text(4, 4), " (t = 0.015 s)");
  EXPECT_EQ(run_at(0.0, 2.0, 10).text(4, 4), " (t = 6 s)");
  EXPECT_EQ(run_at(0.0, 2.5, 10).text(4, 4), " (t = 7.5 s)");
  EXPECT_EQ(run_at(0.0, 1.0 / 30.0, 40).text(31, 31), " (t = 1.00 s)");
  EXPECT_EQ(times.text(201, 201), "");
}

TEST(StepTimes, AreSinceTheFirstRowWhereClocksDifferOrCountFrom1970) {
  StepTimes times = run_at(10.0, 0.5, 20);
  times.merge(run_at(70.0, 0.5, 30));  // longer: its end is told as well
  EXPECT_TRUE(times.known());
  EXPECT_FALSE(times.as_told());
  EXPECT_EQ(times.text(30, 30), " (14.5 s after the start)");
  EXPECT_EQ(run_at(1.7e9, 0.5, 20).text(3, 3), " (1.0 s after the start)");
}

TEST(StepTimes, OfRunsThatBeginLaterOnTheSameClockAreAsTold) {
  StepTimes times = run_at(0.0, 1.0, 10);
  times.begin_run();
  for (std::int64_t k = 4; k <= 12; ++k) times.add(k, static_cast<double>(k) - 0.9);  // a tenth of a step off
  EXPECT_TRUE(times.as_told());
  EXPECT_NEAR(times.at(12), 11.0, 1e-12);
}

// As of targets that are born and die: no step in common, one clock.
TEST(StepTimes, OfRunsWithoutACommonStepAreToldWhereOneClockFits) {
  const auto target = [](std::int64_t first, std::int64_t last) {
    StepTimes times;
    times.begin_run();
    for (std::int64_t k = first; k <= last; ++k) times.add(k, 0.5 * static_cast<double>(k));
    return times;
  };
  StepTimes merged = target(34, 60);
  merged.merge(target(5, 20));
  StepTimes added = target(34, 60);
  added.begin_run();
  for (std::int64_t k = 5; k <= 20; ++k) added.add(k, 0.5 * static_cast<double>(k));
  for (const StepTimes* const times : {&merged, &added}) {
    EXPECT_TRUE(times->known() && times->as_told());
    EXPECT_DOUBLE_EQ(times->at(5), 2.5);
    EXPECT_DOUBLE_EQ(times->at(60), 30.0);
    EXPECT_TRUE(std::isnan(times->at(25)));
  }
}

TEST(StepTimes, AreNotKnownWhereRunsDisagreeByMoreThanHalfAStep) {
  StepTimes other_rate = run_at(0.0, 1.0, 10);
  other_rate.merge(run_at(0.0, 1.1, 10));
  EXPECT_FALSE(other_rate.known());
  StepTimes no_common_step = run_at(0.0, 1.0, 10);
  no_common_step.begin_run();
  no_common_step.add(11, 3.0);
  EXPECT_FALSE(no_common_step.known());
  StepTimes standing;
  standing.add(1, 2.0);
  standing.add(2, 2.0);
  EXPECT_FALSE(standing.known());
}

TEST(StepTimes, OfALongRunEverySecondStepIsKept) {
  StepTimes times = run_at(0.0, 0.25, 2 * kMostSteps);
  EXPECT_DOUBLE_EQ(times.at(kMostSteps + 1), 0.25 * static_cast<double>(kMostSteps));
  EXPECT_TRUE(std::isnan(times.at(kMostSteps)));
  times.merge(run_at(0.0, 0.25, 10));
  StepTimes short_first = run_at(0.0, 0.25, 10);
  short_first.merge(times);
  EXPECT_TRUE(times.known() && short_first.known());
  EXPECT_EQ(short_first.at(kMostSteps + 1), times.at(kMostSteps + 1));
}

}  // namespace
}  // namespace credence::internal
