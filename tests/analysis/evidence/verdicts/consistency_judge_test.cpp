#include "analysis/evidence/verdicts/consistency_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "analysis/laws/mean/run_mean.h"

namespace credence::internal {
namespace {

// A law whose numbers can be written down: P(|sum − expected| ≥ d) = exp(−d).
SumLaw exponential_law(double expected) {
  return {.expected = expected,
          .bounds = [expected](double confidence) -> ChiSquareBounds {
            return {expected + std::log(1.0 - confidence), expected - std::log(1.0 - confidence)};
          },
          .p_value = [expected](double sum) { return std::exp(-std::abs(sum - expected)); }};
}

double sum_of_dofs(const std::vector<StepTest>& tested) {
  double dof = 0.0;
  for (const StepTest& step : tested) dof += step.total_dof;
  return dof;
}

VerdictLaws exponential_laws() {
  return {.step = [](double dof, double) { return exponential_law(dof); },
          .overall = [](const std::vector<StepTest>& tested) { return exponential_law(sum_of_dofs(tested)); },
          .method = "exponential"};
}

// One value a step, so that sums and means are the same.
std::vector<Moments> single_values(const std::vector<double>& values) {
  std::vector<Moments> steps;
  for (const double value : values) steps.push_back({.count = 1, .mean = value, .m2 = 0.0});
  return steps;
}

// Four runs of NEES 2 with one degree of freedom, one of 700 with 1000: the mean of NEES over dof is above 1,
// and the only test is that of the sum, which is too small.
TEST(ConsistencyJudge, OfOneStepTheSumHasTheDirection) {
  RunAverages runs;
  for (int i = 0; i < 4; ++i) runs.add(2.0, 1.0, 1);
  runs.add(700.0, 1000.0, 1000);
  std::vector<Moments> step(1);
  for (const double nees : {2.0, 2.0, 2.0, 2.0, 700.0}) step[0].add(nees);
  const ConsistencyVerdict result = judge_nees(step, std::vector<double>{1004.0}, 0.95, &runs);
  EXPECT_EQ(result.verdict, Verdict::pessimistic);
  EXPECT_EQ(result.optimistic_p_value, 1.0);
}

// Thirty runs of one step, whose NEES is too large, and thirty of a hundred, whose NEES is right: the test of
// the runs rejects, and the mean beside its bounds is that of the runs, not the one of 3,030 values.
TEST(ConsistencyJudge, OfRunsOfDifferentLengthsTheMeanIsTheirs) {
  RunAverages runs;
  std::vector<Moments> steps(100);
  for (int i = 0; i < 30; ++i) {
    const double spread = i % 2 == 0 ? 0.1 : -0.1, high = 1.8 + spread, right = 1.0 + spread;
    runs.add(high, 1.0, 1);
    steps[0].add(high);
    runs.add(100.0 * right, 100.0, 1);
    for (Moments& step : steps) step.add(right);
  }
  std::vector<double> dofs(100, 30.0);
  dofs[0] = 60.0;
  const ConsistencyVerdict v = judge_nees(steps, dofs, 0.95, &runs);
  EXPECT_LE(v.overall_p_value, 0.025);
  EXPECT_NEAR(v.mean, 1.4, 1e-12);
  EXPECT_LT(v.bounds.lower, 1.0);
  EXPECT_GT(v.bounds.upper, 1.0);
  EXPECT_GT(v.mean, v.bounds.upper);
}

// One row of one run is missing: the mean is that over all values.
TEST(ConsistencyJudge, OfRunsThatAreAlikeTheMeanIsOverAllValues) {
  RunAverages runs;
  std::vector<Moments> steps(100);
  double sum = 0.0;
  for (int i = 0; i < 30; ++i) {
    const double nees = 1.0 + 0.01 * i;
    const std::size_t rows = i == 29 ? 99 : 100;
    runs.add(static_cast<double>(rows) * nees, static_cast<double>(rows), 1);
    for (std::size_t k = 0; k < rows; ++k) steps[k].add(nees);
    sum += static_cast<double>(rows) * nees;
  }
  std::vector<double> dofs(100, 30.0);
  dofs.back() = 29.0;
  const ConsistencyVerdict v = judge_nees(steps, dofs, 0.95, &runs);
  EXPECT_NEAR(v.mean, sum / 2999.0, 1e-12);
  EXPECT_NEAR(v.bounds.upper * v.factor.lower / v.mean, 1.0, 0.05);
}

// A filter that diverged: the third power of its average is infinite, and there is no test of the runs.
TEST(ConsistencyJudge, RunsTooFarOffForTheirMomentsAreJudgedByTheirSteps) {
  for (const double nees : {1e90, 1e110, 1e160, 1e300}) {
    RunAverages runs;
    std::vector<Moments> steps(2);
    for (int i = 0; i < 20; ++i) {
      const double last = i == 3 ? nees : 1.1;
      runs.add(0.9 + last, 2.0, 1);
      steps[0].add(0.9);
      steps[1].add(last);
    }
    const ConsistencyVerdict result = judge_nees(steps, std::vector<double>(2, 20.0), 0.95, &runs);
    EXPECT_EQ(result.verdict, Verdict::optimistic) << nees;
    EXPECT_LT(result.optimistic_p_value, 1e-12) << nees;
    EXPECT_TRUE(result.decided_by_steps) << nees;
    EXPECT_EQ(result.worst_step, 1) << nees;
  }
}

// A log with two decimals has errors of 0.00, of which χ² knows none.
TEST(ConsistencyJudge, AValueOfZeroIsRoundedAndNotTooSmall) {
  const auto verdict_of = [](double zero, std::int64_t runs, double dof) {
    std::vector<Moments> steps(200, {.count = runs, .mean = dof, .m2 = 0.0});
    steps[50].mean = steps[70].mean = zero;
    return judge_nees(steps, std::vector<double>(200, dof * static_cast<double>(runs)), 0.95);
  };
  for (const double dof : {1.0, 2.0, 3.0}) {
    const ConsistencyVerdict rounded = verdict_of(0.0, 1, dof);
    EXPECT_EQ(rounded.verdict, Verdict::consistent) << dof;
    EXPECT_EQ(rounded.steps[50].p_value, 1.0);
  }
  EXPECT_EQ(verdict_of(1e-12, 1, 2.0).verdict, Verdict::consistent);
  EXPECT_EQ(verdict_of(1e-12, 1, 2.0).steps[50].simultaneous_lower, 0.0);
  EXPECT_GT(verdict_of(1e-12, 1, 3.0).steps[50].simultaneous_lower, 0.0);
  EXPECT_EQ(verdict_of(1e-12, 1, 3.0).verdict, Verdict::pessimistic)
      << "three that are as small are no rounding";
  EXPECT_EQ(verdict_of(0.0, 5, 1.0).verdict, Verdict::pessimistic) << "nor is zero in five runs";
  EXPECT_EQ(verdict_of(60.0, 1, 1.0).verdict, Verdict::optimistic) << "too large is seen at any dof";
}

TEST(ConsistencyJudge, JoinsStepsAndSumAtHalfTheLevelEach) {
  // Three steps of dof 10 with deviations 2, −8 and 0.5; that of the sum is −5.5.
  const ConsistencyVerdict result =
      judge_sums(single_values({12.0, 2.0, 10.5}), std::vector<double>(3, 10.0), 0.9, exponential_laws());
  EXPECT_EQ(result.method, "exponential");
  EXPECT_NEAR(result.optimistic_p_value, 2.0 * 3.0 * std::exp(-2.0), 1e-14);
  EXPECT_NEAR(result.pessimistic_p_value, 2.0 * 3.0 * std::exp(-8.0), 1e-14);
  EXPECT_EQ(result.p_value, result.pessimistic_p_value);
  EXPECT_NEAR(result.steps_p_value, 3.0 * std::exp(-8.0), 1e-14);
  EXPECT_NEAR(result.overall_p_value, std::exp(-5.5), 1e-14);
  EXPECT_EQ(result.verdict, Verdict::pessimistic);
  EXPECT_EQ(result.worst_step, 1);
  EXPECT_TRUE(result.decided_by_steps);  // 3 exp(−8) < exp(−5.5)
  // Level 0.1/6 of a step and 0.1/2 of the sum.
  EXPECT_NEAR(result.steps[0].upper, 10.0 + std::log(10.0), 1e-12);
  EXPECT_NEAR(result.steps[0].simultaneous_upper, 10.0 + std::log(60.0), 1e-12);
  EXPECT_NEAR(result.steps[2].simultaneous_lower, 10.0 - std::log(60.0), 1e-12);
  EXPECT_NEAR(result.bounds.lower, (30.0 - std::log(20.0)) / 3.0, 1e-12);
  EXPECT_EQ(result.optimistic_steps.count, 0);
  EXPECT_EQ(result.pessimistic_steps.first, 2);
  EXPECT_EQ(result.pessimistic_steps.last, 2);
  EXPECT_NEAR(result.share_outside, 1.0 / 3.0, 1e-15);
}

TEST(ConsistencyJudge, BothDirectionsAtDifferentStepsAreMixed) {
  const ConsistencyVerdict result = judge_sums(single_values({18.0, 19.0, 10.0, 2.0, 1.0}),
                                               std::vector<double>(5, 10.0), 0.9, exponential_laws());
  EXPECT_EQ(result.verdict, Verdict::mixed);
  EXPECT_EQ(result.optimistic_steps.first, 1);
  EXPECT_EQ(result.optimistic_steps.last, 2);
  EXPECT_EQ(result.optimistic_steps.count, 2);
  EXPECT_EQ(result.pessimistic_steps.first, 4);
  EXPECT_EQ(result.pessimistic_steps.last, 5);
  EXPECT_NEAR(result.optimistic_p_value, 10.0 * std::exp(-9.0), 1e-14);
  EXPECT_EQ(result.optimistic_p_value, result.pessimistic_p_value);
  EXPECT_NEAR(result.overall_p_value, 1.0, 1e-14);
  EXPECT_EQ(result.steps_rejected, 4);  // Holm: exp(−8) ≤ 0.1 / 2, exp(0) > 0.1
}

TEST(ConsistencyJudge, TheLawOfAStepIsThatOfItsDofAndCount) {
  VerdictLaws laws = exponential_laws();
  laws.step = [](double dof, double count) { return exponential_law(dof + 100.0 * count); };
  const std::vector<double> dofs = {10.0, 10.0, 20.0, 10.0};
  std::vector<Moments> steps(4, Moments{.count = 5, .mean = 100.0, .m2 = 1.0});
  steps[1].count = 10;
  const ConsistencyVerdict result = judge_sums(steps, dofs, 0.9, laws);
  EXPECT_NEAR(result.steps[0].expected, 102.0, 1e-12);
  EXPECT_NEAR(result.steps[1].expected, 101.0, 1e-12);
  EXPECT_NEAR(result.steps[2].expected, 104.0, 1e-12);
  EXPECT_NEAR(result.steps[3].expected, 102.0, 1e-12);
  EXPECT_NEAR(result.expected, (510.0 + 1010.0 + 520.0 + 510.0) / 25.0, 1e-12);
}

TEST(ConsistencyJudge, WholeRunsDecideInPlaceOfTheSum) {
  RunAverages runs;
  for (int i = 0; i < 15; ++i) {
    runs.add(0.8, 2.0, 2);
    runs.add(1.2, 2.0, 2);
  }
  VerdictLaws laws = exponential_laws();
  laws.overall = [](const std::vector<StepTest>&) -> SumLaw { throw std::logic_error("the sum is asked"); };
  laws.runs = &runs;
  const std::vector<double> dofs(2, 10.0);
  const ConsistencyVerdict result = judge_sums(single_values({10.5, 10.5}), dofs, 0.9, laws);
  const double p = run_mean_p_values(runs.moments, 1.0, 2.0).two_sided();
  EXPECT_EQ(result.verdict, Verdict::pessimistic);  // X is 0.5, though both steps lie above their dof
  EXPECT_NEAR(result.overall_p_value, p, 1e-15);
  EXPECT_NEAR(result.pessimistic_p_value, 2.0 * p, 1e-15);
  EXPECT_NEAR(result.factor.mean, 0.5, 1e-12);
  EXPECT_FALSE(result.decided_by_steps);
  // The mean lies outside the bounds as 1 outside the interval at 0.95.
  const MeanInterval interval = run_mean_interval(runs.moments, 0.95, 2.0);
  EXPECT_NEAR(result.bounds.lower, 10.5 / interval.upper, 1e-12);
  EXPECT_NEAR(result.bounds.upper, 10.5 / interval.lower, 1e-12);
  EXPECT_GT(result.bounds.lower, result.mean);
}

TEST(SumLaws, OfTwoDegreesOfFreedomHaveTheClosedForm) {
  // P(χ²(2) > x) = exp(−x/2).
  const SumLaw plain = chi_square_law(2.0);
  EXPECT_EQ(plain.expected, 2.0);
  EXPECT_NEAR(plain.p_value(8.0), 2.0 * std::exp(-4.0), 1e-12);
  EXPECT_NEAR(plain.p_value(0.1), 2.0 * (1.0 - std::exp(-0.05)), 1e-12);
  EXPECT_NEAR(plain.bounds(0.9).upper, -2.0 * std::log(0.05), 1e-9);
  EXPECT_NEAR(plain.bounds(0.9).lower, -2.0 * std::log(0.95), 1e-9);
  // 3 χ²(2): a multiple of χ² is met exactly by its cumulants 3·2, 9·4, 27·16.
  const SumLaw scaled = cumulant_law({6.0, 36.0, 432.0});
  EXPECT_EQ(scaled.expected, 6.0);
  EXPECT_NEAR(scaled.p_value(24.0), 2.0 * std::exp(-4.0), 1e-9);
  EXPECT_NEAR(scaled.bounds(0.9).upper, -6.0 * std::log(0.05), 1e-8);
  // The mean of χ²(2) beyond its quantile −2 ln q is −2 ln q + 2; two equal terms attain their bound.
  const SumLaw dependent = dependent_law({2.0, 2.0});
  EXPECT_EQ(dependent.expected, 4.0);
  EXPECT_NEAR(dependent.bounds(0.9).upper, 2.0 * (2.0 - 2.0 * std::log(0.05)), 1e-8);
  EXPECT_NEAR(dependent.p_value(2.0 * (2.0 - 2.0 * std::log(0.05))), 0.1, 1e-8);
}

}  // namespace
}  // namespace credence::internal
