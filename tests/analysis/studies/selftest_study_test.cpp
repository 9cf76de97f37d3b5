#include "analysis/studies/selftest_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "analysis/studies/selftest_tests.h"

namespace credence::internal {
namespace {

constexpr int kRuns = SyntheticFilter::kRuns, kSteps = SyntheticFilter::kSteps;

Evidence evidence_of(const SyntheticSetup& setup, int runs = 2 * kRuns, int steps = kSteps) {
  return synthetic_evidence(SyntheticFilter(setup), NoiseSource(5, 1), 0, runs, steps);
}

TEST(SyntheticEvidence, HoldsTheSumsThatTheFilterItselfGives) {
  const SyntheticFilter filter({.noise_ratio = 0.1});
  const NoiseSource noise(5, 1);
  std::vector<Moments> nees(kSteps), nis(kSteps);
  for (int block = 0; block < 2; ++block) add_samples(filter, filter.simulate(noise, block), nees, nis);
  const Evidence e = evidence_of({.noise_ratio = 0.1});
  EXPECT_EQ(e.study.runs, 2 * kRuns);
  for (std::size_t k = 0; k < static_cast<std::size_t>(kSteps); ++k) {
    EXPECT_EQ(e.study.steps[k][Quantity::nees].count, 2 * kRuns);
    EXPECT_NEAR(e.study.steps[k][Quantity::nees].mean, nees[k].mean, 1e-11 * nees[k].mean) << k;
    EXPECT_NEAR(e.study.steps[k][Quantity::nees].m2, nees[k].m2, 1e-10 * nees[k].m2) << k;
    EXPECT_NEAR(e.study.steps[k][Quantity::nis].mean, nis[k].mean, 1e-11 * nis[k].mean) << k;
  }
  EXPECT_EQ(synthetic_dofs(nees, 2.0), std::vector<double>(kSteps, 2.0 * 2 * kRuns));
}

TEST(SyntheticEvidence, TakesAsManyRunsAndStepsAsAsked) {
  const Evidence e = evidence_of({}, kRuns + 3, 10);
  EXPECT_EQ(e.study.runs, kRuns + 3);
  EXPECT_EQ(e.study.steps.size(), 10U);
  const Evidence whole = evidence_of({}, 2 * kRuns);
  EXPECT_EQ(e.study.nees_of_runs.moments.count, kRuns + 3);
  EXPECT_EQ(whole.study.steps[9][Quantity::nees].count, 2 * kRuns);
}

TEST(SyntheticEvidence, RunsTakeTheFiltersInTurn) {
  // The second claims four times the variance: its runs have a quarter of the NEES.
  const SyntheticFilter filters[] = {SyntheticFilter({}), SyntheticFilter({.logged_scale = 4.0})};
  const NoiseSource noise(5, 1);
  const Evidence both = synthetic_evidence(filters, noise, 0, kRuns);
  const Evidence first = synthetic_evidence(filters[0], noise, 0, kRuns);
  ASSERT_EQ(both.study.nees_of_runs.first.size(), first.study.nees_of_runs.first.size());
  for (std::size_t run = 0; run < both.study.nees_of_runs.first.size(); ++run) {
    const double ratio = both.study.nees_of_runs.first[run] / first.study.nees_of_runs.first[run];
    EXPECT_NEAR(ratio, run % 2 == 0 ? 1.0 : 0.25, 1e-12) << run;
  }
}

TEST(SyntheticEvidence, ADefectOfTheLogIsInTheLogAlone) {
  const Evidence right = evidence_of({}), idle = evidence_of(setup_of(Defect::wrong_dof)),
                 gated = evidence_of(setup_of(Defect::gated_innovations)),
                 missing = evidence_of({.every_third_missing = true});
  EXPECT_EQ(idle.state_dim, 3);
  for (const std::size_t k : {0U, 20U, 39U}) {
    const StepStatistics &of_right = right.study.steps[k], &of_idle = idle.study.steps[k];
    EXPECT_NEAR(of_idle[Quantity::nees].mean, of_right[Quantity::nees].mean, 1e-12)
        << "the third state has no error";
    EXPECT_EQ(of_idle.nees_dof, 3 * 2 * kRuns);
    EXPECT_EQ(gated.study.steps[k][Quantity::nees].mean, of_right[Quantity::nees].mean);
  }
  // A gate at 95 % lets 95 % of a consistent filter's innovations pass.
  std::int64_t passed = 0;
  for (const StepStatistics& step : gated.study.steps) passed += step[Quantity::nis].count;
  const double all = 2.0 * kRuns * kSteps;
  EXPECT_NEAR(static_cast<double>(passed), 0.95 * all, 5.0 * std::sqrt(0.95 * 0.05 * all));
  EXPECT_EQ(missing.study.steps[2][Quantity::nis].count, 0);
  EXPECT_EQ(missing.study.steps[3][Quantity::nis].count, 2 * kRuns);
  EXPECT_EQ(evidence_of(setup_of(Defect::shared_prior)).sensors.size(), 2U);
}

TEST(ShippedTests, AreTheSameForEveryStudyOfOneKindAndLieInTheUnitInterval) {
  const SyntheticFilter filter({.noise_ratio = 0.1});
  std::vector<std::vector<TestResult>> studies;
  for (const std::int64_t block : {0, 50}) {
    CalibrationRecorder recorder;
    const Evidence e = synthetic_evidence(filter, NoiseSource(6, 1), block, 4 * kRuns, kSteps, &recorder);
    const auto [calibration, judgement] = judge_rows(e, recorder, 0.95);
    studies.push_back(shipped_tests(e, judgement, calibration));
    double smallest = 1.0;
    for (const NamedTest& test : judgement.tests) smallest = std::fmin(smallest, test.adjusted);
    EXPECT_EQ(studies.back()[studies.back().size() - 2].p_value, smallest) << "all together, Holm";
    EXPECT_EQ(studies.back().back().p_value, judgement.word.p_value);
  }
  ASSERT_EQ(studies[0].size(), studies[1].size());
  for (std::size_t i = 0; i < studies[0].size(); ++i) {
    EXPECT_EQ(studies[0][i].name, studies[1][i].name);
    EXPECT_EQ(studies[0][i].exactness, studies[1][i].exactness);
    for (const auto& study : studies) {
      if (std::isnan(study[i].p_value)) continue;
      EXPECT_GE(study[i].p_value, 0.0) << study[i].name;
      // An e-value below one is written as a p-value above it: no alarm at any level.
      if (!study[i].name.starts_with("e-value")) EXPECT_LE(study[i].p_value, 1.0) << study[i].name;
    }
  }
}

TEST(ShippedTests, ResultsComeBackFromAnotherRankAsTheyWere) {
  const TestResult sent{.name = "NIS of π", .exactness = Exactness::approximate, .p_value = 0.1};
  ByteWriter writer;
  writer.put(sent);
  const std::vector<std::byte> bytes = writer.take();
  ByteReader reader(bytes, "a result");
  TestResult got;
  reader.get(got);
  EXPECT_EQ(got.name, sent.name);
  EXPECT_EQ(got.exactness, sent.exactness);
  EXPECT_EQ(got.p_value, sent.p_value);
}

}  // namespace
}  // namespace credence::internal
