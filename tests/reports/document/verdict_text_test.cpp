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

TEST(VerdictText, OfWhatIsUndecidedItSaysWhy) {
  ConsistencyVerdict verdict;
  verdict.reason = "no values";
  EXPECT_EQ(verdict_sentence("NIS", verdict), "NIS: undecided, no values.");
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
