#include "analysis/evidence/sums/score_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/nan.h"

namespace credence::internal {
namespace {

/// −½ (n ln 2π + ln det P + ε).
double log_density(double dof, double log_determinant, double nees) {
  return -0.5 * (dof * std::log(2.0 * std::numbers::pi) + log_determinant + nees);
}

BlockError position_on_a_line(double error, double variance) {
  return {.error = Vector::Constant(1, error), .P = Matrix::Constant(1, 1, variance)};
}

TEST(ScoreSums, AverageTheLogScoreOverTheStepsOfARun) {
  RunScore run;
  run.add(1.5, 2, -3.0);
  run.add(4.0, 3, 0.5);
  ScoreSums sums;
  run.add_to(sums);
  EXPECT_EQ(sums.log.value.count, 1);
  EXPECT_NEAR(sums.log.value.mean, 0.5 * (log_density(2, -3.0, 1.5) + log_density(3, 0.5, 4.0)), 1e-14);
  EXPECT_NEAR(sums.log.expected.mean, 0.5 * (log_density(2, -3.0, 2.0) + log_density(3, 0.5, 3.0)), 1e-14);
}

TEST(ScoreSums, TakeTheEnergyScoreOfThePositionAtTheEnd) {
  RunScore run;
  run.add(1.0, 1, 0.0);
  run.last_position = position_on_a_line(0.0, 4.0);
  ScoreSums sums;
  run.add_to(sums);
  // The CRPS of N(0, σ²) at 0: σ (√(2/π) − 1/√π), on average σ/√π.
  EXPECT_TRUE(sums.of_position);
  EXPECT_NEAR(sums.energy.value.mean, 2.0 * (std::sqrt(2.0) - 1.0) / std::sqrt(std::numbers::pi), 1e-12);
  EXPECT_NEAR(sums.energy.expected.mean, 2.0 / std::sqrt(std::numbers::pi), 1e-12);
}

TEST(ScoreSums, TakeThatOfTheWhitenedStateWithoutAPosition) {
  RunScore whitened, position;
  whitened.add(7.0, 2, 0.0);
  whitened.add(1.44, 1, 0.0);  // the last step alone counts
  position.last_position = position_on_a_line(1.2, 1.0);
  ScoreSums of_state, of_position;
  whitened.add_to(of_state);
  position.add_to(of_position);
  EXPECT_FALSE(of_state.of_position);
  EXPECT_NEAR(of_state.energy.value.mean, of_position.energy.value.mean, 1e-12);
  EXPECT_NEAR(of_state.energy.expected.mean, of_position.energy.expected.mean, 1e-12);
  EXPECT_EQ(of_position.log.value.count, 0);
}

TEST(ScoreSums, LeaveOutAScoreThatThereIsNot) {
  RunScore singular;
  singular.add(2.0, 2, kNaN);
  singular.add(2.0, 2, 0.0);
  ScoreSums sums;
  singular.add_to(sums);
  EXPECT_EQ(sums.log.value.count, 0);
  EXPECT_EQ(sums.log.expected.count, 0);
  EXPECT_EQ(sums.energy.value.count, 1);

  RunScore broken;
  broken.last_position = position_on_a_line(kNaN, 1.0);
  broken.add_to(sums);
  EXPECT_EQ(sums.energy.value.count, 1);
  EXPECT_EQ(sums.energy.expected.count, 1);

  ScoreSums none;
  RunScore().add_to(none);
  EXPECT_EQ(none.log.value.count, 0);
  EXPECT_EQ(none.energy.value.count, 0);
  EXPECT_FALSE(none.of_position);
}

TEST(ScoreSums, MergeAsIfAddedTogether) {
  ScoreSums first, second, all;
  for (int i = 0; i < 7; ++i) {
    RunScore run;
    run.add(0.5 + i, 2, 0.1 * i);
    if (i > 3) run.last_position = position_on_a_line(0.3 * i, 1.0 + i);
    run.add_to(i < 3 ? first : second);
    run.add_to(all);
  }
  first.merge(second);
  EXPECT_TRUE(first.of_position);
  const auto same = [](const auto& merged, const auto& together) {
    EXPECT_EQ(merged.count, 7);
    EXPECT_EQ(together.count, 7);
    EXPECT_NEAR(merged.mean, together.mean, 1e-14);
    EXPECT_NEAR(merged.m2, together.m2, 1e-12);
  };
  same(first.log.value, all.log.value);
  same(first.log.expected, all.log.expected);
  same(first.energy.value, all.energy.value);
  same(first.energy.expected, all.energy.expected);
  EXPECT_NEAR(first.log.value.m3, all.log.value.m3, 1e-11);
}

}  // namespace
}  // namespace credence::internal
