#include "analysis/laws/sample_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/mean/run_mean.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(SampleSize, PowerOfAConsistentFilterIsTheLevel) {
  for (const double dof : {1.0, 10.0, 1e4})
    EXPECT_NEAR(verdict_power({.dof_per_step = dof}, 1.0, 1.0), 0.05, 1e-10);
}

TEST(SampleSize, TwoDofPowerInClosedForm) {
  // χ²(2): P(χ² > x) = e^{−x/2}. Level 5 %: quantiles −2 ln 0.975 and −2 ln 0.025; factor 2 halves the
  // exponent.
  const double expected = 1.0 - std::sqrt(0.975) + std::sqrt(0.025);
  EXPECT_NEAR(verdict_power({.dof_per_step = 2.0}, 2.0, 1.0), expected, 1e-12);
}

TEST(SampleSize, PowerGrowsWithRunsAndWithTheFactor) {
  const VerdictDesign design{.steps = 50.0, .dof_per_step = 2.0};
  EXPECT_LT(verdict_power(design, 1.2, 50.0), verdict_power(design, 1.2, 200.0));
  EXPECT_LT(verdict_power(design, 1.2, 50.0), verdict_power(design, 1.4, 50.0));
  EXPECT_LT(verdict_power(design, 0.9, 50.0), verdict_power(design, 0.7, 50.0));
}

TEST(SampleSize, RunsNeededAreTheFewest) {
  const VerdictDesign design{.steps = 1.0, .dof_per_step = 2.0};
  for (const double factor : {0.5, 0.9, 1.1, 1.5, 3.0}) {
    const RunsNeeded needed = runs_to_detect(design, factor, 0.9);
    EXPECT_GE(needed.power, 0.9);
    if (needed.runs > 1) {
      EXPECT_LT(verdict_power(design, factor, static_cast<double>(needed.runs - 1)), 0.9) << factor;
    }
  }
  // Normal approximation for a small deviation: M n (ln f)²/2 ≈ (1.96 + 1.2816)².
  const double approximate = 2.0 * std::pow(1.95996 + 1.28155, 2) / (2.0 * std::pow(std::log(1.02), 2));
  EXPECT_NEAR(static_cast<double>(runs_to_detect(design, 1.02, 0.9).runs) / approximate, 1.0, 0.03);
}

TEST(SampleSize, DetectableFactorInvertsRunsNeeded) {
  const VerdictDesign design{.steps = 40.0, .dof_per_step = 2.0, .white = true};
  const DetectableFactors factors = detectable_factors(design, 50.0, 0.9);
  EXPECT_NEAR(verdict_power(design, factors.above, 50.0), 0.9, 1e-6);
  EXPECT_NEAR(verdict_power(design, factors.below, 50.0), 0.9, 1e-6);
  EXPECT_LE(runs_to_detect(design, factors.above * 1.001, 0.9).runs, 50);
  EXPECT_GE(runs_to_detect(design, 1.0 + 0.9 * (factors.above - 1.0), 0.9).runs, 50);
}

// Share of studies that the verdict rejects, with the statistic scaled by `factor`.
double simulated_power(const VerdictDesign& design, double factor, int runs, double phi, int studies,
                       unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const std::size_t steps = static_cast<std::size_t>(design.steps);
  const std::vector<double> dofs(steps, runs * design.dof_per_step);
  int rejected = 0;
  for (int study = 0; study < studies; ++study) {
    std::vector<Moments> moments(steps);
    RunAverages averages;
    for (int run = 0; run < runs; ++run) {
      double a = normal(generator);
      double b = normal(generator);
      RunSum sum;
      for (Moments& step : moments) {
        step.add(factor * (a * a + b * b));
        sum.add(factor * (a * a + b * b), 2);
        a = phi * a + std::sqrt(1.0 - phi * phi) * normal(generator);
        b = phi * b + std::sqrt(1.0 - phi * phi) * normal(generator);
      }
      sum.add_to(averages);
    }
    const ConsistencyVerdict verdict = design.white ? judge_nis(moments, dofs, design.confidence)
                                                    : judge_nees(moments, dofs, design.confidence, &averages);
    rejected += verdict.verdict != Verdict::consistent;
  }
  return static_cast<double>(rejected) / studies;
}

TEST(SampleSize, WhitePlanIsWhatSimulationFinds) {
  constexpr int kStudies = 1000;
  const VerdictDesign design{.steps = 20.0, .dof_per_step = 2.0, .white = true};
  for (const double factor : {0.8, 1.25}) {
    const RunsNeeded needed = runs_to_detect(design, factor, 0.8);
    const double power = simulated_power(design, factor, static_cast<int>(needed.runs), 0.0, kStudies, 1);
    // The plan counts the sum alone: a lower bound, and the steps add little.
    const double error = test::binomial_standard_error(needed.power, kStudies);
    EXPECT_GE(power, needed.power - 5.0 * error) << factor;
    EXPECT_LE(power, needed.power + 0.05 + 5.0 * error) << factor;
    RecordProperty("planned_" + std::to_string(factor), std::to_string(needed.power));
    RecordProperty("simulated_" + std::to_string(factor), std::to_string(power));
  }
}

TEST(SampleSize, CorrelatedPlanIsWhatSimulationFinds) {
  constexpr int kStudies = 1000;
  // φ = 1: one effective step, exact up to the share of the steps' own test.
  const VerdictDesign constant{.steps = 10.0, .dof_per_step = 2.0};
  const RunsNeeded needed = runs_to_detect(constant, 1.5, 0.8);
  const double error = test::binomial_standard_error(needed.power, kStudies);
  EXPECT_NEAR(simulated_power(constant, 1.5, static_cast<int>(needed.runs), 1.0, kStudies, 2), needed.power,
              5.0 * error);
  // φ = 0.9 over 10 steps: at least the power planned for full correlation.
  EXPECT_GE(simulated_power(constant, 1.5, static_cast<int>(needed.runs), 0.9, kStudies, 3),
            needed.power - 5.0 * error);
}

TEST(SampleSize, PlanBySimulatedStudiesIsWhatSimulationFindsInBothDirections) {
  constexpr int kStudies = 2000;
  constexpr int kPlanned = 4000;
  const VerdictDesign design = simulated({.steps = 10.0, .dof_per_step = 2.0}, kPlanned);
  for (const double factor : {0.55, 1.8}) {
    const RunsNeeded needed = runs_to_detect(design, factor, 0.8);
    ASSERT_LE(needed.runs, 60) << "the law of the sum would do";
    const double error = std::hypot(test::binomial_standard_error(needed.power, kStudies),
                                    test::binomial_standard_error(needed.power, kPlanned));
    const double power = simulated_power(design, factor, static_cast<int>(needed.runs), 1.0, kStudies, 5);
    EXPECT_GE(power, needed.power - 5.0 * error) << factor;
    // The larger of the two parts of the verdict, a lower bound: of a P that is too large and few runs the
    // single steps, whose law is known, find what the averages of runs do not.
    if (factor > 1.0) {
      EXPECT_LE(power, needed.power + 5.0 * error);
    }
  }
}

// By a χ² of all dof 254 runs were to find a P too large by 1.12 in 80 %, and as many optimistic ones.
TEST(SampleSize, PlanOfManySkewedRunsIsWhatSimulationFinds) {
  constexpr int kStudies = 3000, kRuns = 254;
  const VerdictDesign design =
      simulated({.steps = 100.0, .dof_per_step = 3.0, .effective_steps = 2.0, .run_skewness = 2.5}, 1000);
  // Pearson's type III of variance 2/6 and this skewness.
  const double shape = 4.0 / (2.5 * 2.5), scale = 1.0 / std::sqrt(3.0 * shape);
  std::mt19937_64 generator(12);
  std::gamma_distribution<double> gamma(shape, scale);
  for (const double factor : {1.12, 1.0 / 1.12}) {
    int found = 0;
    for (int study = 0; study < kStudies; ++study) {
      SkewedMoments moments;
      for (int run = 0; run < kRuns; ++run)
        moments.add(factor * std::max(0.0, 1.0 + gamma(generator) - shape * scale));
      const DirectedPValues p = run_mean_p_values(moments, 1.0, 3.0);
      found += (factor > 1.0 ? p.optimistic : p.pessimistic) <= 0.0125;
    }
    const double planned = verdict_power(design, factor, kRuns);
    EXPECT_NEAR(static_cast<double>(found) / kStudies, planned,
                0.01 + 5.0 * test::binomial_standard_error(planned, kStudies))
        << factor;
  }
}

TEST(SampleSize, RunsForPrecisionAreThoseOfTheNormalLawWhereTheyAreMany) {
  // n = 2, one effective step: the mean of M values of relative variance 1 to ± 1 %, z² / precision².
  const VerdictDesign constant{.steps = 10.0, .dof_per_step = 2.0};
  EXPECT_NEAR(static_cast<double>(runs_for_precision(constant, 0.01)) / 38415.0, 1.0, 0.002);
  EXPECT_EQ(runs_for_precision(constant, 100.0), 2);
  VerdictDesign five = constant;
  five.effective_steps = 5.0;
  EXPECT_NEAR(static_cast<double>(runs_for_precision(five, 0.01)) / 7683.0, 1.0, 0.005);
}

// Half-widths of the interval over studies of so many runs, whose averages are χ²(n T_eff)/(n T_eff).
Moments simulated_half_widths(const VerdictDesign& design, std::int64_t runs, int studies) {
  const double dof = design.dof_per_step * design.effective_steps;
  std::mt19937_64 generator(7);
  std::gamma_distribution<double> average(0.5 * dof, 2.0 / dof);
  Moments widths;
  for (int study = 0; study < studies; ++study) {
    SkewedMoments moments;
    for (std::int64_t run = 0; run < runs; ++run) moments.add(average(generator));
    widths.add(run_mean_interval(moments, design.confidence, design.dof_per_step).half_width());
  }
  return widths;
}

TEST(SampleSize, RunsForPrecisionGiveTheHalfWidthThatIsAskedForOnAverage) {
  constexpr int kStudies = 400;
  // Of 15 independent steps 20 runs, by the moments that they have on average, gave ±11 % for ±10 %.
  for (const double effective : {1.0, 15.0, 20.0, 300.0}) {
    constexpr int kPlanned = 1000;
    const VerdictDesign design =
        simulated({.steps = 300.0, .dof_per_step = 4.0, .effective_steps = effective}, kPlanned);
    for (const double precision : {0.05, 0.1, 0.3}) {
      const std::int64_t runs = runs_for_precision(design, precision);
      const Moments planned = simulated_half_widths(design, runs, kStudies);
      const double error = std::sqrt(planned.variance() * (1.0 / kStudies + 1.0 / kPlanned));
      EXPECT_LE(planned.mean, precision + 5.0 * error) << effective << ", " << runs << " runs";
      EXPECT_GT(simulated_half_widths(design, (runs - 1) * 4 / 5, kStudies).mean, precision)
          << effective << ", fewer than " << runs << " runs";
    }
  }
}

TEST(SampleSize, RejectsImpossiblePlans) {
  const VerdictDesign design;
  EXPECT_THROW(runs_to_detect(design, 1.0, 0.9), std::invalid_argument);
  EXPECT_THROW(runs_to_detect(design, -1.0, 0.9), std::invalid_argument);
  EXPECT_THROW(runs_to_detect(design, 2.0, 1.0), std::invalid_argument);
  EXPECT_THROW(runs_to_detect(design, 1.0 + 1e-9, 0.9), std::invalid_argument);
  EXPECT_THROW(verdict_power({.steps = 0.0}, 2.0, 10.0), std::invalid_argument);
  EXPECT_THROW(verdict_power(design, 2.0, 0.0), std::invalid_argument);
  EXPECT_THROW(verdict_power({.dof_per_step = 0.0}, 2.0, 10.0), std::invalid_argument);
  EXPECT_THROW(runs_for_precision(design, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
