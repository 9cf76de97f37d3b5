#include "analysis/studies/selftest_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "analysis/evidence/sequential/sequential_e_value.h"
#include "analysis/laws/joint/betting_e_value.h"
#include "analysis/studies/selftest_study.h"

namespace credence::internal {
namespace {

struct ShippedStudy {
  Evidence evidence;
  Judgement judgement;
  Calibration calibration;
  std::vector<TestResult> tests;

  explicit ShippedStudy(Defect defect, int runs = SyntheticFilter::kRuns) {
    CalibrationRecorder recorder;
    const SyntheticFilter filter(setup_of(defect));
    evidence = synthetic_evidence(filter, NoiseSource(21, 9), 0, runs, SyntheticFilter::kSteps, &recorder);
    JudgedRows judged = judge_rows(evidence, recorder, 0.95);
    judgement = std::move(judged.judgement);
    calibration = std::move(judged.calibration);
    tests = shipped_tests(evidence, judgement, calibration);
  }
  const TestResult& operator[](std::string_view name) const {
    const auto found = std::ranges::find(tests, name, &TestResult::name);
    EXPECT_NE(found, tests.end()) << name;
    return *found;
  }
};

TEST(SelftestTests, AreThoseOfTheJudgementAndThenTheOthersInOneOrder) {
  const ShippedStudy exact(Defect::none), wrong(Defect::measurement_noise_too_small);
  ASSERT_EQ(exact.tests.size(), wrong.tests.size());
  for (std::size_t i = 0; i < exact.tests.size(); ++i) EXPECT_EQ(exact.tests[i].name, wrong.tests[i].name);
  const std::size_t judged = exact.judgement.tests.size();
  ASSERT_EQ(exact.tests.size(), judged + 10 + exact.evidence.blocks.size());
  for (std::size_t i = 0; i < judged; ++i) {
    EXPECT_EQ(exact.tests[i].name, exact.judgement.tests[i].name);
    const double p = exact.judgement.tests[i].p_value;
    EXPECT_TRUE(exact.tests[i].p_value == p || (std::isnan(p) && std::isnan(exact.tests[i].p_value)));
  }
  EXPECT_EQ(exact.tests.back().name, "the word");
  EXPECT_EQ(exact.tests.back().p_value, exact.judgement.word.p_value);
}

// Of an exact filter the interval of the score holds what a right P has; of one whose errors are larger than
// it says it does not.
TEST(SelftestTests, TheIntervalOfTheScoreMissesWhatAWrongFilterClaims) {
  const ShippedStudy exact(Defect::none), wrong(Defect::measurement_noise_too_small);
  EXPECT_EQ(exact["interval of the log score"].p_value, 1.0);
  EXPECT_EQ(wrong["interval of the log score"].p_value, 0.01);
  EXPECT_EQ(exact["interval of the energy score"].p_value, 1.0);
  EXPECT_EQ(exact["NIS far out"].p_value, 1.0);
}

TEST(SelftestTests, TheIntervalOfTheRmseMissesWhatAWrongFilterClaims) {
  const ShippedStudy exact(Defect::none), wrong(Defect::measurement_noise_too_small);
  ASSERT_FALSE(exact.evidence.blocks.empty());
  for (const BlockSums& block : exact.evidence.blocks) {
    const std::string name = "interval of the RMSE of " + block.name;
    EXPECT_GE(exact[name].p_value, 0.05) << name;
    EXPECT_EQ(wrong[name].p_value, 0.01) << name;
  }
}

TEST(SelftestTests, TogetherAreTheLeastThatIsAdjusted) {
  const ShippedStudy study(Defect::process_noise_too_small);
  double least = 1.0;
  for (const NamedTest& test : study.judgement.tests) {
    if (test.adjusted < least) least = test.adjusted;
  }
  EXPECT_EQ(study["all tests together, Holm"].p_value, least);
  EXPECT_LT(least, 0.05);
  double bins = 1.0;
  for (const SigmaBin& bin : study.calibration.bins) {
    if (bin.adjusted < bins) bins = bin.adjusted;
  }
  EXPECT_EQ(study["errors by claimed σ, Holm"].p_value, bins);
}

TEST(SelftestTests, BetsOverRunsAreTheirProducts) {
  // betting_e_value.h: W⁺ and W⁻ of the runs' averages, multiplied out; steps of two degrees of freedom.
  const ShippedStudy study(Defect::none, 12);
  const std::vector<double>& averages = study.evidence.study.nees_of_runs.first;
  ASSERT_EQ(averages.size(), 12U);
  double optimistic = 0.0, pessimistic = 0.0;
  for (const double share : kOptimisticShares) {
    double capital = 1.0;
    for (const double x : averages) capital *= 1.0 + share * (x - 1.0);
    optimistic += capital / static_cast<double>(kOptimisticShares.size());
  }
  for (const double strike : kPessimisticStrikes) {
    // E(χ²₂/2 − b)⁺ = e⁻ᵇ, that of an exponential law.
    const double price = strike - 1.0 + std::exp(-strike);
    for (const double share : kPessimisticShares) {
      double capital = 1.0;
      for (const double x : averages) capital *= 1.0 - share + share * std::max(strike - x, 0.0) / price;
      pessimistic += capital / static_cast<double>(kPessimisticStrikes.size() * kPessimisticShares.size());
    }
  }
  const double expected = 2.0 / (optimistic + pessimistic);
  EXPECT_NEAR(study["e-value of NEES, betting over runs"].p_value, expected, 1e-9 * expected);
}

TEST(SelftestTests, EValuesAreSmallWhereTheFilterIsWrongAlone) {
  const ShippedStudy exact(Defect::none), wrong(Defect::measurement_noise_too_small);
  for (const char* name :
       {"e-value of NEES, steps", "e-value of NEES, betting over runs", "e-value of NIS"}) {
    EXPECT_GT(exact[name].p_value, 0.01) << name;
    EXPECT_LT(wrong[name].p_value, 0.01) << name;
    EXPECT_EQ(exact[name].exactness, Exactness::conservative);
  }
}

TEST(SelftestTests, TravelAsBytes) {
  const TestResult sent{"a name with σ", Exactness::approximate, 0.125};
  ByteWriter writer;
  write_value(writer, sent);
  const std::vector<std::byte> bytes = writer.take();
  ByteReader reader(bytes, "a test");
  TestResult received;
  read_value(reader, received);
  EXPECT_EQ(received.name, sent.name);
  EXPECT_EQ(received.exactness, sent.exactness);
  EXPECT_EQ(received.p_value, sent.p_value);
}

// Studies of one kind may lack tests, as those of an angle that is never beyond half a turn.
TEST(SelftestTests, AlarmsAreCountedByNames) {
  const auto result = [](const char* name, double p_value) {
    return TestResult{.name = name, .p_value = p_value};
  };
  const std::vector<std::vector<TestResult>> studies = {
      {result("NEES", 0.01), result("the word", 0.5)},
      {result("NEES", 0.2), result("cross-covariances", 0.001), result("the word", 0.05)},
      {result("NEES", kNaN), result("cross-covariances", 0.4), result("the word", 0.04)}};
  std::vector<std::pair<std::string, std::int64_t>> counted;
  for (const AlarmCount& count : count_alarms(studies, 0.05))
    counted.emplace_back(count.test->name, count.alarms);
  EXPECT_EQ(counted, (std::vector<std::pair<std::string, std::int64_t>>{
                         {"NEES", 1}, {"the word", 2}, {"cross-covariances", 1}}));
}

}  // namespace
}  // namespace credence::internal
