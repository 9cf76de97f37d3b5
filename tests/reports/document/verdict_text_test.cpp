#include "reports/document/verdict_text.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

Word optimistic() {
  return {.verdict = Verdict::optimistic, .p_value = 1e-9, .says = "optimistic from step 3 on", .joined = {}};
}

ConsistencyVerdict with_factor(double mean, double lower, double upper) {
  ConsistencyVerdict nees;
  nees.factor = {.mean = mean, .lower = lower, .upper = upper};
  return nees;
}

TEST(VerdictText, AFactorIsSaidWhereItIsOneThatMends) {
  EXPECT_EQ(word_clause(optimistic(), with_factor(1.3, 1.1, 1.5)),
            "optimistic from step 3 on; scaling P by 1.30 would make the mean NEES right");
  EXPECT_EQ(word_clause(optimistic(), with_factor(1.05, 0.9, 1.2)), "optimistic from step 3 on")
      << "one agrees as well";
  EXPECT_EQ(word_clause(optimistic(), with_factor(1.001, 1.0005, 1.002)), "optimistic from step 3 on")
      << "which would be 1.00";
  Word mixed = optimistic();
  mixed.verdict = Verdict::mixed;
  EXPECT_EQ(word_clause(mixed, with_factor(1.3, 1.1, 1.5)), "optimistic from step 3 on")
      << "no single factor mends it";
  ConsistencyVerdict known = with_factor(2.0, 1.9, 2.1);
  BlockVerdict acceleration{.name = "acc", .verdict = with_factor(6.0, 5.8, 6.2)};
  known.confidence = acceleration.verdict.confidence = 0.95;
  EXPECT_EQ(
      word_clause(optimistic(), known, std::vector{acceleration}),
      "optimistic from step 3 on; scaling P by 2.00 would make the mean NEES right but leave acc optimistic");
  ConsistencyVerdict unknown = with_factor(1.3, 1.1, 1.5);
  unknown.factor.reason = "fewer than two runs";
  EXPECT_EQ(word_sentence("loop", optimistic(), unknown), "loop: optimistic from step 3 on.");
}

TEST(VerdictText, TrustsWithinTheBoundsOfWhatDecided) {
  ConsistencyVerdict v;
  v.bounds = {.lower = 0.7, .upper = 1.4};
  v.steps.resize(20);
  v.steps[11] = {.mean = 9.0, .simultaneous_lower = 0.01, .simultaneous_upper = 7.5};
  v.worst_step = 11;
  EXPECT_EQ(trusted_text(v), "0.7000 … 1.400");
  v.verdict = Verdict::optimistic;
  EXPECT_EQ(trusted_text(v), "0.7000 … 1.400");
  v.decided_by_steps = true;
  EXPECT_EQ(trusted_text(v), "0.01000 … 7.500 at step 12, has 9.000");
  v.step_stride = 10;
  EXPECT_EQ(trusted_text(v), "0.01000 … 7.500 at step 111, has 9.000");
  v.decided_by_sensors = true;
  EXPECT_EQ(trusted_text(v), "each sensor by itself");
}

TEST(VerdictText, ColoursWhatMustNotBeTrusted) {
  EXPECT_EQ(verdict_cell(Verdict::consistent).tone, CellTone::good);
  for (const Verdict verdict : {Verdict::optimistic, Verdict::mixed}) {
    EXPECT_EQ(verdict_cell(verdict).tone, CellTone::alarm);
  }
  for (const Verdict verdict : {Verdict::pessimistic, Verdict::undecided, Verdict::not_gaussian}) {
    EXPECT_EQ(verdict_cell(verdict).tone, CellTone::caution);
  }
}

TEST(VerdictText, ARunIsOneAndSeveralAreMany) {
  const std::string converged =
      " the filter's iteration stopped before it had converged; its last iterate is used there.";
  const std::vector<RunNotConverged> one = {{.run = 0, .steps = 1}};
  EXPECT_EQ(not_converged_sentence(one, 5), "In 1 step of 1 of 5 runs (run 0)" + converged);
  EXPECT_EQ(not_converged_sentence(one, 1), "In 1 step of the only run" + converged);
  std::vector<RunNotConverged> many = {{.run = 5, .steps = 3}, {.run = 7, .steps = 4}};
  EXPECT_EQ(not_converged_sentence(many, 9), "In 7 steps of 2 of 9 runs (runs 5, 7)" + converged);
  many.resize(6, {.run = 8, .steps = 1});
  EXPECT_EQ(not_converged_sentence(many, 9),
            "In 11 steps of 6 of 9 runs (runs 5, 7, 8, 8, 8, …)" + converged);
  EXPECT_EQ(not_converged_sentence({}, 9), "");
}

TEST(VerdictText, AFilterHasTheFactorsOnItsNoise) {
  FilterSettings filter;
  filter.process_scale = 1e-9;
  filter.measurement_scale = 0.25;
  EXPECT_EQ(filter_text(filter), "none, Q × 1e−9, R × 0.25");
}

TEST(VerdictText, OfWhatIsUndecidedItSaysWhy) {
  ConsistencyVerdict verdict;
  verdict.reason = "no values";
  EXPECT_EQ(verdict_sentence("NIS", verdict), "NIS: undecided, no values.");
}

ConsistencyVerdict within_bounds(Verdict verdict) {
  ConsistencyVerdict v;
  v.verdict = verdict;
  v.confidence = 0.95;
  v.p_value = 0.25;
  v.mean = 1.25;
  v.expected = 2.0;
  v.bounds = {.lower = 1.0, .upper = 3.0};
  v.count = 30;
  v.tests = 4;
  v.share_outside = 0.3;
  v.expected_share_outside = 0.05;
  return v;
}

TEST(VerdictText, OfAMeanWithinItsBoundsItSaysWhatDecided) {
  ConsistencyVerdict v = within_bounds(Verdict::pessimistic);
  v.decided_by_sensors = true;
  EXPECT_EQ(verdict_sentence("NIS", v),
            "NIS: pessimistic. Each sensor is judged by itself, and the smallest p-value counts, times the "
            "number of sensors (p = 0.250). The mean of all 30 values is 1.250, around 2.000; 30.0 % of the "
            "steps lie outside their own bounds, where 5.00 % are expected.");
  v = within_bounds(Verdict::optimistic);
  v.decided_by_steps = true;
  v.steps.resize(3);
  v.steps[2] = {.mean = 9.0, .simultaneous_lower = 0.5, .simultaneous_upper = 7.5};
  v.worst_step = 2;
  EXPECT_EQ(
      verdict_sentence("NEES", v),
      "NEES: optimistic. The mean of 1.250 over 30 values would be accepted from 1.000 to 3.000, around "
      "2.000 (95 % confidence, p = 0.250, 4 tests); what decided is step 3, whose mean of 9.000 would "
      "be accepted from 0.5000 to 7.500; 30.0 % of the steps lie outside their own bounds, where 5.00 % "
      "are expected.");
}

TEST(VerdictText, ManyStepsOutsideOfAConsistentFilterAreExplained) {
  ConsistencyVerdict v = within_bounds(Verdict::consistent);
  EXPECT_TRUE(verdict_sentence("NEES", v).ends_with(
      "where 5.00 % are expected on average: errors last over steps, so that of one right filter many lie "
      "outside and of another none."));
  v.share_outside = 0.06;
  EXPECT_TRUE(verdict_sentence("NEES", v).ends_with("where 5.00 % are expected."));
}

TEST(VerdictText, NamesTheFilterAsItIsSet) {
  FilterSettings filter;
  EXPECT_EQ(filter_text(filter), "none");
  filter.inflation = FilterInflation::rank;
  filter.inflation_rank = 2;
  filter.process_scale = 0.25;
  EXPECT_EQ(filter_text(filter).substr(0, 7), "rank 2 ");
  EXPECT_NE(filter_text(filter).find(", Q × 0.25"), std::string::npos);
  EXPECT_EQ(filter_text(filter).find("R ×"), std::string::npos);
}

}  // namespace
}  // namespace credence::internal
