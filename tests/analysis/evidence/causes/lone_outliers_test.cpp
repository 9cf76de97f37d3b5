#include "analysis/evidence/causes/lone_outliers.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace credence::internal {
namespace {

/// Of two dof χ² is beyond 2 · 13.8 once in a million.
constexpr double kDof = 2.0, kWithin = 13.8, kBeyond = 13.9;

std::vector<double> run_with(std::vector<std::size_t> beyond, std::size_t rows = 100) {
  std::vector<double> run(rows, kWithin);
  for (const std::size_t row : beyond) run[row] = kBeyond;
  return run;
}

std::optional<LoneOutliers> found_in(const std::vector<std::vector<double>>& runs) {
  return find_lone_outliers(runs, kDof);
}

TEST(LoneOutliers, AreCountedAndTheFirstIsNamed) {
  const std::vector<std::vector<double>> runs = {run_with({}), run_with({40, 60}), run_with({99})};
  const auto found = found_in(runs);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->count, 3);
  EXPECT_EQ(found->rows, 300);
  EXPECT_EQ(found->run, 1);
  EXPECT_EQ(found->row, 40);
  EXPECT_FALSE(found->at_one_step);
  EXPECT_TRUE(found_in({run_with({}), run_with({40}), run_with({40})})->at_one_step);
}

TEST(LoneOutliers, ErrorsThatFadeAreNone) {
  EXPECT_FALSE(found_in({run_with({40, 41, 42})}).has_value());
  // One pair of eleven, and of nine.
  EXPECT_TRUE(found_in({run_with({40, 41, 50, 55, 60, 65, 70, 75, 80, 85, 90}, 300)}).has_value());
  EXPECT_FALSE(found_in({run_with({40, 41, 50, 55, 60, 65, 70, 75, 80}, 300)}).has_value());
}

TEST(LoneOutliers, ThoseOfTheStartAreNone) {
  EXPECT_FALSE(found_in({run_with({0}), run_with({0}), run_with({50})}).has_value());
  EXPECT_TRUE(found_in({run_with({9}), run_with({50})}).has_value());
  // What a P0 too small makes fades: rows beside are larger than 99 in 100, NEES / dof of two dof
  // beyond 4.605.
  std::vector<double> run(100, 1.0);
  run[4] = kBeyond;
  EXPECT_TRUE(found_in({run}).has_value());
  run[5] = 4.7;
  EXPECT_FALSE(found_in({run}).has_value());
  run[5] = 4.5;
  EXPECT_TRUE(found_in({run}).has_value());
}

TEST(LoneOutliers, ManyAreNone) {
  EXPECT_TRUE(found_in({run_with({20, 30, 40, 50, 60})}).has_value());
  EXPECT_FALSE(found_in({run_with({20, 30, 40, 50, 60, 70})}).has_value());
  EXPECT_FALSE(found_in({run_with({})}).has_value());
  EXPECT_FALSE(found_in({}).has_value());
}

}  // namespace
}  // namespace credence::internal
