#include "analysis/evidence/causes/advice.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/evidence/causes/advice_cause.h"
#include "analysis/laws/mean/run_mean.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

ConsistencyVerdict nees_verdict(double mean_per_dof, double dof, std::int64_t runs = 100,
                                std::size_t steps = 40) {
  const std::vector<Moments> moments(steps, Moments{.count = runs, .mean = mean_per_dof * dof, .m2 = 1.0});
  return judge_nees(moments, std::vector<double>(steps, static_cast<double>(runs) * dof), 0.95);
}

ConsistencyVerdict nis_verdict(double mean_per_dof, double dof) {
  const std::vector<Moments> moments(40, Moments{.count = 100, .mean = mean_per_dof * dof, .m2 = 1.0});
  return judge_nis(moments, std::vector<double>(40, 100.0 * dof), 0.95);
}

TEST(Advice, ScaleOfCovarianceCoversTheTrueFactor) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(1);
  std::chi_squared_distribution<double> chi(2.0);
  int covered = 0;
  for (int study = 0; study < kStudies; ++study) {
    RunAverages runs;
    for (int run = 0; run < 50; ++run) runs.add(1.8 * chi(generator), 2.0, 2);
    ConsistencyVerdict nees;
    nees.factor = run_mean_interval(runs.moments, 0.95, 2.0);
    const ScaleAdvice scale = scale_of_covariance(nees);
    covered += scale.lower <= 1.8 && 1.8 <= scale.upper;
  }
  EXPECT_NEAR(covered / 2000.0, 0.95, 5.0 * test::binomial_standard_error(0.05, kStudies));
  ConsistencyVerdict unknown;
  unknown.factor.reason = "no runs";
  EXPECT_EQ(scale_of_covariance(unknown).reason, "no runs");
}

/// With this factor, known to a tenth at 95 %.
BlockVerdict block_with_factor(const char* name, double factor) {
  BlockVerdict block{.name = name, .verdict = {}};
  block.verdict.confidence = 0.95;
  block.verdict.factor = {.mean = factor, .lower = factor / 1.1, .upper = factor * 1.1};
  return block;
}

TEST(Advice, OneFactorLeavesThePartsThatAskForOthers) {
  const auto left = [](std::vector<double> factors) {
    std::vector<BlockVerdict> blocks;
    for (std::size_t i = 0; i < factors.size(); ++i) {
      blocks.push_back(block_with_factor(std::array{"pos", "vel", "acc"}[i], factors[i]));
    }
    return left_by_scale(block_with_factor("", 2.0).verdict, blocks);
  };
  EXPECT_EQ(left({2.0, 2.1, 1.9}), "");
  EXPECT_EQ(left({1.1, 1.4, 6.0}), "acc optimistic and pos pessimistic");
  EXPECT_EQ(left({2.0, 3.0, 6.0}), "acc optimistic");
  EXPECT_EQ(left({2.0, 1.3, 2.0}), "vel pessimistic");
  // Logarithms known to 0.0486, the difference to 0.0688: 2.3 standard deviations, p = 0.0214. Of one block
  // that is significant, of three it is not.
  EXPECT_EQ(left({2.343}), "pos optimistic");
  EXPECT_EQ(left({2.343, 2.0, 2.0}), "");
  BlockVerdict unknown = block_with_factor("", 2.0);
  unknown.verdict.factor.reason = "no runs";
  EXPECT_EQ(left_by_scale(unknown.verdict, std::vector{block_with_factor("pos", 9.0)}), "");
}

TEST(Advice, OneFactorLeavesTheStepsThatAskForOthers) {
  ConsistencyVerdict nees = block_with_factor("", 2.0).verdict;
  const auto step = [](double mean) {
    return StepTest{.mean = mean, .expected = 3.0, .simultaneous_lower = 2.5, .simultaneous_upper = 3.5};
  };
  nees.steps = {step(6.0), step(5.0), step(7.5)};
  EXPECT_EQ(left_by_scale(nees, {}), "") << "within 2/1.1 × 2.5 = 4.55 and 2 × 1.1 × 3.5 = 7.7";
  nees.steps = {step(4.5), step(3.0), step(7.6), step(7.8)};
  EXPECT_EQ(left_by_scale(nees, {}), "step 4 optimistic and steps 1 to 2 pessimistic");
  nees.step_stride = 10;
  EXPECT_EQ(left_by_scale(nees, {}), "step 31 optimistic and steps 1 to 11 pessimistic");
  EXPECT_EQ(left_by_scale(nees, std::vector{block_with_factor("pos", 9.0)}), "pos optimistic")
      << "a part of the state says more";
  nees.steps = {StepTest{.mean = kNaN, .simultaneous_lower = kNaN, .simultaneous_upper = kNaN}};
  EXPECT_EQ(left_by_scale(nees, {}), "");
}

// Parts that are wrong by one factor are called different in at most 5 % of all studies.
TEST(Advice, OneFactorThatIsRightLeavesNothing) {
  constexpr int kStudies = 200;
  std::mt19937_64 generator(8);
  std::chi_squared_distribution<double> chi(2.0);
  int said = 0;
  for (int study = 0; study < kStudies; ++study) {
    std::array<RunAverages, 3> parts;
    RunAverages whole;
    for (int run = 0; run < 30; ++run) {
      double sum = 0.0;
      for (RunAverages& part : parts) {
        const double value = 1.8 * chi(generator);
        part.add(value, 2.0, 2);
        sum += value;
      }
      whole.add(sum, 6.0, 6);
    }
    const auto verdict = [](const RunAverages& runs, double dof) {
      ConsistencyVerdict nees;
      nees.confidence = 0.95;
      nees.factor = run_mean_interval(runs.moments, 0.95, dof);
      return nees;
    };
    std::vector<BlockVerdict> blocks;
    for (const RunAverages& part : parts) blocks.push_back({"part", verdict(part, 2.0)});
    said += left_by_scale(verdict(whole, 6.0), blocks).empty() ? 0 : 1;
  }
  EXPECT_LE(said, 0.05 * kStudies + 5.0 * std::sqrt(0.05 * 0.95 * kStudies));
}

TEST(Advice, ScaleOfInnovationHasTheExactInterval) {
  const ScaleAdvice scale = scale_of_innovation(nis_verdict(1.3, 2.0));
  EXPECT_NEAR(scale.factor, 1.3, 1e-12);
  EXPECT_NEAR(scale.lower, 1.3 * 8000.0 / chi_square_upper_quantile(0.025, 8000.0), 1e-9);
  EXPECT_NEAR(scale.upper, 1.3 * 8000.0 / chi_square_quantile(0.025, 8000.0), 1e-9);
  EXPECT_FALSE(scale_of_innovation(ConsistencyVerdict{}).reason.empty());
}

TEST(Advice, ScaleOfMeasurementNoiseUsesItsShareOfS) {
  const ScaleAdvice scale{.factor = 1.3, .lower = 1.2, .upper = 1.4, .reason = {}};
  const ScaleAdvice of_R = scale_of_measurement_noise(scale, 0.5);
  EXPECT_NEAR(of_R.factor, 1.6, 1e-12);
  EXPECT_NEAR(of_R.lower, 1.4, 1e-12);
  EXPECT_NEAR(of_R.upper, 1.8, 1e-12);
  const ScaleAdvice small{.factor = 0.4, .lower = 0.3, .upper = 0.5, .reason = {}};
  EXPECT_FALSE(scale_of_measurement_noise(small, 0.5).reason.empty());
  EXPECT_EQ(scale_of_measurement_noise(small, 0.65).lower, 0.0);
  EXPECT_THROW(scale_of_measurement_noise(scale, 0.0), std::invalid_argument);
  EXPECT_THROW(scale_of_measurement_noise(scale, 1.1), std::invalid_argument);
}

TEST(Advice, NamesTheBlockThatDeviatesMost) {
  const std::vector<BlockVerdict> blocks{{"position", nees_verdict(1.05, 2.0)},
                                         {"heading", nees_verdict(2.5, 1.0)},
                                         {"landmark 1", nees_verdict(1.6, 2.0)}};
  const ResponsibleBlock block = responsible_block(nees_verdict(1.6, 5.0), blocks);
  EXPECT_EQ(block.index, 1);
  EXPECT_FALSE(block.joint_only);
}

TEST(Advice, NoBlockIsNamedWhenNoneFails) {
  const std::vector<BlockVerdict> blocks{{"position", nees_verdict(1.0, 2.0)},
                                         {"heading", nees_verdict(1.02, 1.0)}};
  EXPECT_EQ(responsible_block(nees_verdict(1.0, 3.0), blocks).index, -1);
  EXPECT_FALSE(responsible_block(nees_verdict(1.0, 3.0), blocks).joint_only);
  EXPECT_TRUE(responsible_block(nees_verdict(2.0, 3.0), blocks).joint_only);
  EXPECT_FALSE(responsible_block(nees_verdict(2.0, 3.0), {}).joint_only);
  // A block without data is no member.
  const std::vector<BlockVerdict> with_empty{{"nothing", ConsistencyVerdict{}}};
  EXPECT_EQ(responsible_block(nees_verdict(1.0, 3.0), with_empty).index, -1);
}

TEST(Advice, RunsToSettleAnOpenCase) {
  const VerdictDesign design{.steps = 40.0, .dof_per_step = 2.0};
  const ConsistencyVerdict open = nees_verdict(1.1, 2.0);
  ASSERT_EQ(open.verdict, Verdict::consistent);
  const SettlingRuns settling = runs_to_settle(open, design, 100.0, 0.9);
  EXPECT_GT(settling.runs, 100);
  EXPECT_GE(verdict_power(design, 1.1, static_cast<double>(settling.runs)), 0.9);
  EXPECT_GT(settling.detectable.above, 1.1);
  EXPECT_LT(settling.detectable.below, 1.0);
  EXPECT_FALSE(runs_to_settle(nees_verdict(3.0, 2.0), design, 100.0, 0.9).reason.empty());
  EXPECT_FALSE(runs_to_settle(nees_verdict(1.0, 2.0), design, 100.0, 0.9).reason.empty());
  EXPECT_FALSE(runs_to_settle(ConsistencyVerdict{}, design, 100.0, 0.9).reason.empty());
}

bool names(const std::vector<CauseFound>& found, Cause cause) {
  for (const CauseFound& entry : found) {
    if (entry.cause == cause) return true;
  }
  return false;
}

WhitenessTest whiteness(double lag_1) {
  WhitenessTest test;
  test.autocorrelation = {lag_1};
  test.band = {0.05};
  test.p_value = std::abs(lag_1) > 0.05 ? 1e-6 : 0.5;
  test.white = test.p_value > 0.05;
  return test;
}

TEST(Causes, AConsistentFilterHasNone) {
  Findings findings{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(1.0, 1.0)};
  findings.whiteness = whiteness(0.01);
  EXPECT_TRUE(find_causes(findings).empty());
  EXPECT_TRUE(find_causes(Findings{}).empty());
}

TEST(Causes, SignsOfNisAndAutocorrelationNameTheNoise) {
  const struct {
    double nis, lag_1;
    Cause cause;
  } cases[] = {{1.3, 0.2, Cause::process_noise_too_small},
               {1.3, -0.2, Cause::measurement_noise_too_small},
               {0.7, 0.15, Cause::measurement_noise_too_large},
               {0.7, -0.2, Cause::process_noise_too_large},
               {1.0, 0.2, Cause::coloured_noise},
               {0.82, 0.38, Cause::coloured_noise}};
  for (const auto& [nis, lag_1, cause] : cases) {
    Findings findings{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(nis, 1.0)};
    findings.whiteness = whiteness(lag_1);
    findings.not_white = true;
    EXPECT_TRUE(names(find_causes(findings), cause)) << to_string(cause);
    EXPECT_EQ(find_causes(findings).size(), 1U);
  }
}

TEST(Causes, FirstStepsOnlyPointToTheInitialCovariance) {
  std::vector<Moments> moments(40, Moments{.count = 100, .mean = 2.0, .m2 = 1.0});
  moments[0].mean = 6.0;
  moments[1].mean = 3.5;
  const std::vector<double> dofs(40, 200.0);
  Findings findings{.nees = judge_nees(moments, dofs, 0.95), .nis = nis_verdict(1.0, 1.0)};
  EXPECT_TRUE(names(find_causes(findings), Cause::initial_covariance));
  moments[30].mean = 6.0;
  findings.nees = judge_nees(moments, dofs, 0.95);
  EXPECT_FALSE(names(find_causes(findings), Cause::initial_covariance));
}

TEST(Causes, SpreadOfNeesTellsDofFromScale) {
  // Mean 3 where 2 was expected: χ²(3) has variance 6, 1.5 χ²(2) has 9.
  Findings findings{.nees = nees_verdict(1.5, 2.0), .nis = nis_verdict(1.0, 1.0)};
  findings.nees_values = {.count = 1000, .mean = 3.0, .m2 = 6.0 * 999.0};
  EXPECT_TRUE(names(find_causes(findings), Cause::wrong_dof));
  findings.any_block_is_wrong = true;
  EXPECT_FALSE(names(find_causes(findings), Cause::wrong_dof)) << "each block has its own dof";
  findings.any_block_is_wrong = false;
  findings.nees_values.m2 = 9.0 * 999.0;
  EXPECT_TRUE(names(find_causes(findings), Cause::covariance_scale));
  EXPECT_FALSE(names(find_causes(findings), Cause::wrong_dof));
}

TEST(Causes, OutliersGateBiasAndCrossCovariance) {
  Findings findings{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(3.0, 1.0)};
  findings.far_tail = CoverageCount{.inside = 3900, .total = 4000};
  EXPECT_TRUE(names(find_causes(findings), Cause::outliers));

  Findings turned{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(3.0, 1.0)};
  turned.unwrapped_innovations = 1;
  EXPECT_EQ(find_causes(turned).front().cause, Cause::unwrapped_angle);

  Findings gate{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(0.95, 2.0)};
  gate.gate = GateFound{.nis = 9.2, .expected = 50.0, .p_value = 0.4};
  EXPECT_TRUE(names(find_causes(gate), Cause::gated_innovations));

  Findings bias{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(1.1, 1.0)};
  bias.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(1, 0.3), .p_value = 1e-4};
  EXPECT_TRUE(names(find_causes(bias), Cause::bias));

  Findings cross{.nees = nees_verdict(2.0, 3.0), .nis = nis_verdict(1.0, 1.0)};
  cross.block = ResponsibleBlock{.index = -1, .joint_only = true};
  EXPECT_TRUE(names(find_causes(cross), Cause::cross_covariance));

  Findings correlated{.nees = nees_verdict(2.0, 3.0), .nis = nis_verdict(1.0, 1.0)};
  correlated.error_correlation = ErrorCorrelationTest{.runs = 100, .largest = 0.5, .p_value = 1e-6};
  EXPECT_TRUE(names(find_causes(correlated), Cause::cross_covariance));
  correlated.error_correlation->p_value = 0.03;  // not for all causes together
  EXPECT_FALSE(names(find_causes(correlated), Cause::cross_covariance));

  Findings white{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(1.3, 1.0)};
  white.measurement_noise_share = 0.95;
  white.whiteness = whiteness(0.01);
  // A Q that is wrong could hide in a band this wide.
  EXPECT_TRUE(names(find_causes(white), Cause::process_or_measurement_noise));
  white.whiteness->band = {0.01};
  EXPECT_TRUE(names(find_causes(white), Cause::measurement_noise_too_small));
  white.measurement_noise_share = 0.5;
  EXPECT_TRUE(names(find_causes(white), Cause::process_or_measurement_noise));
}

TEST(Causes, ASmallAutocorrelationOfItsOwnTellsQFromR) {
  Findings findings{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(0.9, 2.0)};
  findings.measurement_noise_share = 0.95;
  findings.whiteness = whiteness(-0.04);
  findings.whiteness->band = {0.01};  // all lags together do not speak
  EXPECT_EQ(find_causes(findings).front().cause, Cause::process_noise_too_large);
}

TEST(Causes, NoiseBesideABias) {
  Findings findings{.nees = nees_verdict(1.0, 2.0), .nis = nis_verdict(1.5, 2.0)};
  findings.innovation_mean = ZeroMeanTest{.mean = Vector::Constant(2, 0.7), .p_value = 1e-9};
  findings.whiteness = whiteness(0.49 / 1.5);
  findings.not_white = true;
  // What the bias adds, 0.49 a component, leaves white innovations of the right size.
  ASSERT_EQ(find_causes(findings).size(), 1U);
  EXPECT_EQ(find_causes(findings).front().cause, Cause::bias);

  findings.nis = nis_verdict(2.0, 2.0);  // 1.51 is left, with an autocorrelation of 0.3
  findings.whiteness = whiteness((0.3 * 1.51 + 0.49) / 2.0);
  const std::vector<CauseFound> small = find_causes(findings);
  ASSERT_EQ(small.size(), 2U);
  EXPECT_EQ(small[0].cause, Cause::bias);
  EXPECT_EQ(small[1].cause, Cause::process_noise_too_small);

  findings.whiteness = whiteness(0.49 / 2.0);
  EXPECT_EQ(find_causes(findings).at(1).cause, Cause::process_or_measurement_noise);
}

}  // namespace
}  // namespace credence::internal
