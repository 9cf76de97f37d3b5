#include "reports/document/verdict_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace credence::internal {
namespace {

/// Runs of five steps with the given mean NEES of 3 dof, 40 runs each; count 0: no data.
ConsistencyVerdict judged(const std::vector<double>& means) {
  std::vector<Moments> steps;
  std::vector<double> dofs;
  for (const double mean : means) {
    Moments moments;
    for (int run = 0; run < 40 && mean > 0.0; ++run) moments.add(run % 2 == 0 ? 0.5 * mean : 1.5 * mean);
    steps.push_back(moments);
    dofs.push_back(mean > 0.0 ? 120.0 : 0.0);
  }
  return judge_nees(steps, dofs, 0.95);
}

TEST(VerdictJson, SaysWhatTheVerdictSaysAndNullWhereThereAreNoData) {
  ConsistencyVerdict verdict = judged({3.0, 9.0, 0.0, 9.0, 3.0});
  verdict.step_stride = 10;
  const Json j = verdict_json(verdict);
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_DOUBLE_EQ(j["mean"], (3.0 + 9.0 + 9.0 + 3.0) / 4.0);
  EXPECT_EQ(j["expected"], 3.0);
  EXPECT_EQ(j["values"], 160);
  EXPECT_EQ(j["dof"], 480.0);
  EXPECT_EQ(j["steps_without_data"], 1);
  ASSERT_EQ(j["per_step"].size(), 5U);
  EXPECT_EQ(j["per_step"][1], 9.0);
  for (const char* part : {"per_step", "per_step_p_value"}) EXPECT_TRUE(j[part][2].is_null()) << part;
  EXPECT_TRUE(j["per_step_bounds"]["lower"][2].is_null());
  EXPECT_LT(j["per_step_bounds"]["lower"][0].get<double>(), 3.0);
  EXPECT_GT(j["per_step_bounds"]["upper"][0].get<double>(), 3.0);
  // Entries 2 and 4, of every tenth step from the first on.
  EXPECT_EQ(j["optimistic_steps"]["first"], 11);
  EXPECT_EQ(j["optimistic_steps"]["last"], 31);
  EXPECT_EQ(j["optimistic_steps"]["count"], 2);
  EXPECT_TRUE(j["pessimistic_steps"].is_null());
  EXPECT_TRUE(j["worst_step"] == 11 || j["worst_step"] == 31);
  EXPECT_EQ(j["bounds"]["upper"], j["per_step_bounds"]["upper"][4]);
  EXPECT_EQ(j["p_value"], j["optimistic_p_value"]);
  EXPECT_EQ(j["decided_by"], "step");
}

TEST(VerdictJson, WithoutAnyDataEveryNumberIsNullWithTheReason) {
  const Json j = verdict_json(judged({0.0, 0.0}));
  EXPECT_EQ(j["verdict"], "undecided");
  EXPECT_FALSE(j["reason"].empty());
  for (const char* number : {"p_value", "decided_by", "worst_step", "steps_p_value", "optimistic_steps"}) {
    EXPECT_TRUE(j[number].is_null()) << number << j[number];
  }
  EXPECT_TRUE(j["bounds"]["lower"].is_null());
  EXPECT_TRUE(j["factor"]["value"].is_null() || j["factor"].contains("reason"));
  EXPECT_FALSE(verdict_json(judged({3.0})).contains("reason"));
}

TEST(VerdictJson, NoNumberIsInfinite) {
  ConsistencyVerdict verdict = judged({3.0});
  verdict.factor.upper = verdict.bounds.upper = std::numeric_limits<double>::infinity();
  const Json j = verdict_json(verdict);
  EXPECT_TRUE(j["factor"]["upper"].is_null());
  EXPECT_TRUE(j["overall"]["upper"].is_null());
  EXPECT_EQ(text_of_json(j).find("inf"), std::string::npos);
}

TEST(VerdictJson, AWordHasWhatItJoins) {
  Word word;
  word.verdict = Verdict::optimistic;
  word.p_value = 0.001;
  word.says = "optimistic in heading";
  word.joined = {{"nees", Verdict::optimistic, 0.001}, {"nis", Verdict::undecided, std::nan("")}};
  const Json j = word_json(word);
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_EQ(j["says"], "optimistic in heading");
  ASSERT_EQ(j["joined"].size(), 2U);
  EXPECT_EQ(j["joined"][0]["adjusted_p_value"], 0.001);
  EXPECT_EQ(j["joined"][1]["verdict"], "undecided");
  EXPECT_TRUE(j["joined"][1]["adjusted_p_value"].is_null());
}

TEST(VerdictJson, EveryOutcomeIsCountedOnceAndTheyAreAllRuns) {
  StudyStatistics statistics;
  statistics.runs = 10;
  statistics.failures = {
      {3, 2, Outcome::diverged}, {5, 1, Outcome::diverged}, {7, 4, Outcome::not_positive_definite}};
  const Json j = outcome_counts_json(statistics);
  EXPECT_EQ(j["diverged"], 2);
  EXPECT_EQ(j["not_positive_definite"], 1);
  std::int64_t sum = 0;
  for (const auto& count : j) sum += count.get<std::int64_t>();
  EXPECT_EQ(sum, 10);
  const std::vector<RunNotConverged> runs = {{.run = 4, .steps = 2}, {.run = 9, .steps = 1}};
  const Json list = not_converged_json(runs);
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[1]["run"], 9);
  EXPECT_EQ(list[0]["steps"], 2);
  EXPECT_TRUE(not_converged_json({}).is_array());
}

}  // namespace
}  // namespace credence::internal
