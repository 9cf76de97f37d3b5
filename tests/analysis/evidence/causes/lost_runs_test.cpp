#include "analysis/evidence/causes/lost_runs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/evidence/sums/evidence.h"

namespace credence::internal {
namespace {

/// NEES over dof of consistent runs whose errors are correlated by `memory` from row to row.
std::vector<std::vector<double>> consistent_runs(std::size_t runs, std::size_t rows, int dof, double memory,
                                                 unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> nees(runs, std::vector<double>(rows));
  for (std::vector<double>& run : nees) {
    std::vector<double> error(static_cast<std::size_t>(dof));
    for (double& e : error) e = normal(random);
    for (double& value : run) {
      value = 0.0;
      for (double& e : error) {
        e = memory * e + std::sqrt(1.0 - memory * memory) * normal(random);
        value += e * e / dof;
      }
    }
  }
  return nees;
}

LostRuns lost_of(std::span<const std::vector<double>> nees, double least_dof) {
  std::vector<CourseOfRun> runs;
  for (const std::vector<double>& run : nees)
    runs.push_back({.run = std::ssize(runs), .course = course_of(run, least_dof)});
  return find_lost_runs(runs);
}

TEST(LostRuns, ARunThatDivergesIsNamedWithTheRowFromWhichOn) {
  auto nees = consistent_runs(20, 100, 3, 0.9, 1);
  for (std::size_t k = 50; k < 100; ++k) nees[7][k] += 60.0;
  const LostRuns lost = lost_of(nees, 3.0);
  ASSERT_EQ(lost.runs.size(), 1U);
  EXPECT_EQ(lost.runs[0].run, 7);
  EXPECT_EQ(lost.runs[0].row, 51);
  EXPECT_NEAR(lost.runs[0].factor, 31.0, 1.0);
  EXPECT_EQ(lost.others, 19);
  EXPECT_NEAR(lost.factor_of_others, 1.0, 0.3);
  EXPECT_TRUE(lost.others_are_right());
  EXPECT_EQ(names_of(lost), "run 7 (of 0 to 19)");
  LostRuns named = lost;
  named.runs[0].name = "run 13 of dv";
  EXPECT_EQ(name_of(lost.runs[0]), "run 7");
  EXPECT_EQ(names_of(named), "run 13 of dv");
}

// Which is what a filter does that ends where it notices.
TEST(LostRuns, OfARunThatFailedThreeRowsAreEnough) {
  std::vector<CourseOfRun> runs(20, {.course = {.mean = 1.0, .rows = 50}});
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].run = static_cast<std::int64_t>(i);
  runs[4].course = {.mean = 12.0, .rows = 9, .beyond = 3, .first = 7};
  EXPECT_TRUE(find_lost_runs(runs).runs.empty());
  runs[4].failed_at = 10;
  const LostRuns lost = find_lost_runs(runs);
  ASSERT_EQ(lost.runs.size(), 1U);
  EXPECT_EQ(lost.runs[0].run, 4);
  EXPECT_EQ(lost.runs[0].row, 7);
  EXPECT_EQ(lost.runs[0].failed_at, 10);
  EXPECT_EQ(lost.others, 19);
  EXPECT_DOUBLE_EQ(lost.factor_of_others, 1.0);
  runs[4].course.beyond = 2;
  EXPECT_TRUE(find_lost_runs(runs).runs.empty());
}

TEST(LostRuns, ARowIsAStepWhereEveryRunHasAllSteps) {
  ConsistencyVerdict nees;
  nees.steps.resize(3);
  RunSums runs;
  runs.nees = {{1.0, 1.0, 1.0}, {1.0, 1.0, 9.0}};
  EXPECT_TRUE(rows_are_steps(runs, nees));
  nees.step_stride = 2;
  EXPECT_FALSE(rows_are_steps(runs, nees));
  nees.step_stride = 1;
  runs.further = {{.rows = 3}};
  EXPECT_TRUE(rows_are_steps(runs, nees));
  runs.further[0].rows = 2;
  EXPECT_FALSE(rows_are_steps(runs, nees));
  runs.further.clear();
  runs.failed = {{.run = 2, .failed_at = 3, .course = {.rows = 2}}};
  EXPECT_TRUE(rows_are_steps(runs, nees));
  runs.failed[0].course.rows = 1;
  EXPECT_FALSE(rows_are_steps(runs, nees));
  runs.failed.clear();
  runs.nees[0].pop_back();
  EXPECT_FALSE(rows_are_steps(runs, nees));
  const LostRun lost{.run = 1, .row = 3};
  EXPECT_EQ(place_of(lost, false, nees), "its row 3");
  EXPECT_EQ(place_of(lost, true, nees), "step 3");
  nees.times = StepTimes::every(0.5);
  EXPECT_EQ(place_of(lost, true, nees), "step 3 (t = 1.5 s)");
}

// A factor near 1 that is known well is no chance.
TEST(LostRuns, ManyOthersThatAreALittleWrongAreWrong) {
  auto nees = consistent_runs(200, 100, 3, 0.9, 1);
  for (std::size_t k = 50; k < 100; ++k) nees[7][k] += 60.0;
  EXPECT_TRUE(lost_of(nees, 3.0).others_are_right());
  for (std::vector<double>& run : nees)
    for (double& value : run) value *= 1.2;
  const LostRuns lost = lost_of(nees, 3.0);
  EXPECT_NEAR(lost.factor_of_others, 1.2, 0.05);
  EXPECT_FALSE(lost.others_are_right());
}

TEST(LostRuns, OfConsistentRunsNoneIsLost) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    const double memory = seed % 2 == 0 ? 0.0 : 0.99;
    EXPECT_TRUE(
        lost_of(consistent_runs(20, 60, 1 + static_cast<int>(seed % 3), memory, seed), 1.0).runs.empty())
        << seed;
  }
}

TEST(LostRuns, ManyAreTheFilterAndNotTheRuns) {
  auto nees = consistent_runs(20, 100, 3, 0.0, 2);
  for (std::size_t run = 0; run < 5; ++run)
    for (double& value : nees[run]) value *= 40.0;
  EXPECT_EQ(lost_of(nees, 3.0).runs.size(), 5U);
  EXPECT_EQ(names_of(lost_of(nees, 3.0)), "runs 0, 1, 2, 3, 4 (of 0 to 19)");
  for (double& value : nees[5]) value *= 40.0;
  EXPECT_TRUE(lost_of(nees, 3.0).runs.empty()) << "more than a quarter";
}

TEST(LostRuns, OthersThatAreWrongTooAreNoBackground) {
  auto nees = consistent_runs(20, 100, 3, 0.0, 3);
  for (double& value : nees[4]) value *= 40.0;
  for (auto& run : nees)
    for (double& value : run) value *= 1.7;
  EXPECT_EQ(lost_of(nees, 3.0).runs.size(), 1U);
  for (auto& run : nees)
    for (double& value : run) value *= 1.3;
  EXPECT_TRUE(lost_of(nees, 3.0).runs.empty());
}

TEST(LostRuns, AFewOutliersAreNoLostRun) {
  auto nees = consistent_runs(20, 100, 3, 0.0, 4);
  for (std::size_t k = 0; k < 9; ++k) nees[4][10 * k] = 500.0;
  EXPECT_TRUE(lost_of(nees, 3.0).runs.empty());
  nees[4][95] = 500.0;
  EXPECT_EQ(lost_of(nees, 3.0).runs.size(), 1U);
}

TEST(LostRuns, FewerThanFiveRunsTellNothing) {
  auto nees = consistent_runs(4, 100, 3, 0.0, 5);
  for (double& value : nees[1]) value *= 40.0;
  EXPECT_TRUE(lost_of(nees, 3.0).runs.empty());
  EXPECT_TRUE(lost_of({}, 3.0).runs.empty());
}

}  // namespace
}  // namespace credence::internal
