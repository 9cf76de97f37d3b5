#include "analysis/evidence/sums/whole_turns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

WholeTurns of(std::initializer_list<double> errors, double variance) {
  WholeTurns turns;
  for (const double error : errors) {
    if (WholeTurns::concerns(error, variance)) turns.add(error, variance);
  }
  return turns;
}

TEST(WholeTurns, ErrorsAboutATurnAreToldFromOnesOfAnySize) {
  const auto off = turns_off(of({0.1, 6.2, -6.35, -0.2, 6.28}, 0.01));
  ASSERT_TRUE(off);
  EXPECT_EQ(off->count, 3);
  EXPECT_FALSE(off->degrees);
  EXPECT_TRUE(turns_off(of({358.0, -361.0, 355.0}, 4.0))->degrees);
  EXPECT_TRUE(turns_off(of({6.2, -6.35}, 0.01)));
  EXPECT_FALSE(turns_off(of({6.2}, 0.01))) << "one may be chance";
  WholeTurns runs;
  runs.add_run(of({6.2, 6.3, 6.35, 6.25}, 0.01), 6);
  EXPECT_FALSE(turns_off(runs)) << "a bias is in all rows of a run";
  EXPECT_FALSE(turns_off(of({6.2, -6.35, 6.28, 4.0}, 0.01))) << "nor are outliers all of one size";
  EXPECT_FALSE(turns_off(of({6.2, -6.35, 6.28, 9.0}, 0.01)));
  EXPECT_FALSE(turns_off(of({7.2, -7.35, 8.28}, 1.0))) << "as large as heavy tails of a wide P";
}

/// Headings that go round in circles, with a right P, in runs of 100 steps.
Evidence of_headings(int runs, bool marked, double unit) {
  RunLayout layout{.states = {"x", "heading"}, .angles = {false, marked}};
  add_named_blocks(layout);
  layout.sensors = {{.name = "compass", .dim = 1, .piece = 1, .angles = {marked}}};
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Step step;
  step.states = {0, 1};
  step.P = Vector(Eigen::Vector2d(1.0, 0.01 * unit * unit)).asDiagonal();
  step.innovations = {{.nu = Vector(1), .S = Matrix::Constant(1, 1, 0.02 * unit * unit)}};
  const auto wrapped = [](double angle) { return wrap_angle(angle); };
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run();
    for (step.step = 1; step.step <= 100; ++step.step) {
      const double heading = wrapped(0.1 * static_cast<double>(step.step)), error = 0.1 * normal(random);
      const double sum = wrapped(heading + error), difference = sum - heading;
      step.error = Eigen::Vector2d(normal(random), unit * (marked ? wrapped(difference) : difference));
      const double measured = 0.1 * std::sqrt(2.0) * normal(random);
      const double innovation = wrapped(heading + measured) - heading;
      step.innovations[0].nu[0] = unit * (marked ? wrapped(innovation) : innovation);
      recorder.add(step);
    }
  }
  return recorder.take();
}

TEST(WholeTurns, AnAngleThatNobodyMarkedIsTheCause) {
  for (const int runs : {4, 40}) {
    for (const double unit : {1.0, 1.0 / kRadiansPerDegree}) {
      const Judgement j = judge(of_headings(runs, false, unit), {});
      ASSERT_FALSE(j.causes.empty()) << runs;
      EXPECT_EQ(j.causes.front().cause, Cause::unwrapped_angle);
      EXPECT_NE(j.causes.front().why.find("values of heading are a whole turn"), std::string::npos);
      EXPECT_NE(j.causes.front().why.find("of the innovation of compass"), std::string::npos);
      EXPECT_EQ(j.causes.front().why.find("degrees") == std::string::npos, unit == 1.0);
      EXPECT_FALSE(j.scale_covariance.reason.empty()) << "no factor on P mends it";
    }
    EXPECT_TRUE(judge(of_headings(runs, true, 1.0), {}).causes.empty());
  }
}

TEST(WholeTurns, MergeAsIfTheyHadBeenOfOne) {
  WholeTurns one = of({6.2, 4.0}, 0.01);
  one.merge(of({-6.3, 400.0}, 0.01));
  EXPECT_EQ(one, of({6.2, 4.0, -6.3, 400.0}, 0.01));
  EXPECT_NEAR(WholeTurns::kTurns[0], kTurn, 1e-15);
}

}  // namespace
}  // namespace credence::internal
