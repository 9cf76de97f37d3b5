#include "reports/document/study/judgement_json.h"

#include <gmock/gmock.h>

#include <initializer_list>
#include <limits>

#include "core/nan.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> keys_of(const Json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

TEST(JudgementJson, WhatIsNotThereIsNullOrEmpty) {
  const Json j = as_read(judgement_json({}));
  EXPECT_TRUE(j["responsible_block"].is_null());
  EXPECT_TRUE(j["settle"]["nees"]["runs"].is_null()) << "0 stands for no number of runs";
  EXPECT_TRUE(j["rmse"]["heading_rad"]["value"].is_null());
  EXPECT_EQ(j["rmse"]["heading_rad"]["reason"], "no run ended well");
  EXPECT_EQ(as_read(judgement_json({.runs = 2}))["rmse"]["heading_rad"]["reason"],
            "not a part of this state");
  EXPECT_TRUE(j["shape"]["p_value"].is_null());
  for (const char* list :
       {"tests", "blocks", "causes", "lost_runs", "autocorrelation", "accuracy", "sensor_pairs"}) {
    EXPECT_EQ(j[list], Json::array()) << list;
  }
  EXPECT_FALSE(j["scale"]["covariance"].contains("reason"));
  EXPECT_THAT(keys_of(j),
              ElementsAre("runs", "tests", "blocks", "responsible_block", "joint_only", "causes", "lost_runs",
                          "scale", "settle", "coverage", "autocorrelation", "credibility", "rmse", "accuracy",
                          "second_moments", "shape", "gaussianity", "equivalence", "scores", "sensor_pairs",
                          "effective_steps", "null_reason"))
      << "the order of docs/formats.md";
}

// A 0 would be read as what was measured: of dB as a P that is perfect.
TEST(JudgementJson, NoZeroStandsForWhatWasNotMeasured) {
  Judgement judgement;
  judgement.credibility.reason = "fewer whole runs than dimensions";
  judgement.settle_nis.reason = "no data";
  judgement.law.energy_score.reason = "no run";
  judgement.law.shape.reason = "too many states";
  judgement.law.second_moments.test = test_second_moments({}, 0.95);
  const Json j = as_read(judgement_json(judgement));
  const auto null = [](const Json& object, std::initializer_list<const char*> keys) {
    for (const char* key : keys) {
      ASSERT_TRUE(object.contains(key)) << key;
      EXPECT_TRUE(object[key].is_null()) << key << object[key];
    }
    EXPECT_FALSE(object.value("reason", "").empty()) << object;
  };
  null(j["credibility"], {"noncredibility_db", "floor_db", "inclination_db"});
  null(j["settle"]["nis"], {"observed_factor", "runs", "detectable_below", "detectable_above"});
  null(j["scores"]["energy"], {"mean", "lower", "upper", "expected"});
  null(j["shape"], {"step", "p_value", "proved_within", "proved_at_step"});
  null(j["second_moments"], {"optimistic_p_value", "pessimistic_p_value", "worst_factor", "worst_lower",
                             "worst_upper", "least_factor", "largest_factor"});
  for (const Json& coverage : j["coverage"]) null(coverage, {"expected_share", "p_value"});
}

TEST(JudgementJson, AZeroThatWasMeasuredStaysOne) {
  Judgement judgement;
  judgement.nees.count = 40;
  judgement.settle_nees = {.observed_factor = 0.0, .reason = "the verdict is settled"};
  judgement.credibility = {.runs = 5};
  judgement.law.log_score.value = {.count = 5};
  judgement.law.shape.tests = 1;
  judgement.coverage[0].pooled = {.inside = 0, .total = 5};
  const Json j = as_read(judgement_json(judgement));
  EXPECT_EQ(j["settle"]["nees"].dump(),
            R"({"observed_factor":0.0,"runs":null,"detectable_below":null,"detectable_above":null,)"
            R"("reason":"the verdict is settled"})");
  EXPECT_EQ(j["credibility"].dump(), R"({"noncredibility_db":0.0,"floor_db":0.0,"inclination_db":0.0})");
  EXPECT_EQ(j["scores"]["log"]["mean"], 0.0);
  EXPECT_EQ(j["shape"]["step"], 0);
  EXPECT_EQ(j["coverage"][0]["expected_share"], 0.0);
  EXPECT_FALSE(j["coverage"][0].contains("reason"));
}

TEST(JudgementJson, NamesTheResponsibleBlockAndItsCauses) {
  Judgement judgement;
  judgement.runs = 12;
  judgement.blocks.resize(2);
  judgement.blocks[0].name = "position";
  judgement.blocks[1].name = "heading";
  judgement.blocks[1].verdict.verdict = Verdict::optimistic;
  judgement.blocks[1].verdict.mean = 1.5;
  judgement.blocks[1].verdict.p_value = 0.0;
  judgement.blocks[0].verdict.reason = "no data";
  judgement.responsible.index = 1;
  judgement.causes = {{Cause::bias, "the innovations have a mean"}};
  judgement.lost = {.runs = {{.run = 7, .row = 51, .factor = 30.5}}, .others = 19};
  const Json j = as_read(judgement_json(judgement));
  EXPECT_EQ(j["runs"], 12);
  EXPECT_EQ(j["responsible_block"], "heading");
  EXPECT_EQ(j["blocks"][1].dump(),
            R"({"name":"heading","mean":1.5,"expected":0.0,"p_value":0.0,"verdict":"optimistic"})");
  EXPECT_TRUE(j["blocks"][0]["p_value"].is_null());
  EXPECT_EQ(j["blocks"][0]["reason"], "no data");
  EXPECT_EQ(j["causes"][0]["why"], "the innovations have a mean");
  EXPECT_EQ(j["causes"][0]["cause"], to_string(Cause::bias));
  EXPECT_EQ(j["lost_runs"][0]["run"], 7);
  EXPECT_EQ(j["lost_runs"][0]["row"], 51);
  EXPECT_EQ(j["lost_runs"][0]["factor"], 30.5);
}

// Mean squared errors become roots; the efficiency is bound over mean squared error, 1/4 in [1/16, 1].
TEST(JudgementJson, AccuracyIsOfRootsAndHasABoundWhereOneIsKnown) {
  Judgement judgement;
  BlockAccuracy row;
  row.of = "position";
  row.unit = "m";
  row.squared_error.mean = 4.0;
  row.squared_error.lower = 1.0;
  row.squared_error.upper = 16.0;
  row.squared_error.count = 5;
  row.claimed = 9.0;
  judgement.accuracy = {row, row};
  judgement.accuracy[1].bound = 1.0;
  judgement.accuracy[1].at_truth = 2.25;
  const Json j = judgement_json(judgement)["accuracy"];
  EXPECT_EQ(j[0].dump(),
            R"({"of":"position","unit":"m","rmse":{"value":2.0,"lower":1.0,"upper":4.0},"claimed":3.0})");
  EXPECT_EQ(j[1]["bound"], 1.0);
  EXPECT_EQ(j[1]["at_truth"], 1.5);
  EXPECT_EQ(j[1]["efficiency"].dump(), R"({"value":0.25,"lower":0.0625,"upper":1.0})");
}

TEST(JudgementJson, TellsWhatOneFactorOnPLeaves) {
  const auto of_factor = [](double factor) {
    ConsistencyVerdict nees;
    nees.confidence = 0.95;
    nees.factor = {.mean = factor, .lower = factor / 1.1, .upper = factor * 1.1};
    return nees;
  };
  Judgement judgement;
  judgement.nees = of_factor(2.0);
  judgement.blocks = {{"position", of_factor(1.2)}, {"heading", of_factor(6.0)}};
  judgement.scale_covariance = scale_of_covariance(judgement.nees);
  const auto leaves = [&] { return judgement_json(judgement)["scale"]["covariance"]["leaves"]; };
  EXPECT_EQ(leaves(), "heading optimistic and position pessimistic");
  judgement.blocks.clear();
  EXPECT_EQ(leaves(), "");
  judgement.blocks = {{"heading", of_factor(6.0)}};
  judgement.nees = of_factor(1.05);
  EXPECT_EQ(leaves(), "") << "the factor may be 1, so that there is nothing to scale";
}

TEST(JudgementJson, WhatIsNotFiniteIsNullAndItsReasonBesideIt) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Judgement judgement;
  judgement.scale_innovation = {.factor = kNaN, .lower = kNaN, .upper = kNaN, .reason = "no innovations"};
  judgement.nis.count = 1;
  judgement.settle_nis.runs = 40;
  judgement.settle_nis.detectable = {.below = 0.5, .above = kInfinity};
  judgement.position = {.rmse = 0.25, .lower = kNaN, .upper = kNaN, .count = 1, .reason = "one run"};
  judgement.law.second_moments.test.reason = "one component";
  judgement.law.second_moments.test.largest_factor = kInfinity;
  judgement.effective_steps = kNaN;
  const Json j = as_read(judgement_json(judgement));
  EXPECT_EQ(j["scale"]["innovation"].dump(),
            R"({"factor":null,"lower":null,"upper":null,"reason":"no innovations"})");
  EXPECT_EQ(j["settle"]["nis"].dump(),
            R"({"observed_factor":1.0,"runs":40,"detectable_below":0.5,"detectable_above":null})");
  EXPECT_EQ(j["rmse"]["position_m"].dump(), R"({"value":0.25,"lower":null,"upper":null,"reason":"one run"})");
  EXPECT_EQ(j["second_moments"]["of"], "state");
  EXPECT_TRUE(j["second_moments"]["largest_factor"].is_null());
  EXPECT_EQ(j["second_moments"]["reason"], "one component");
  EXPECT_TRUE(j["effective_steps"].is_null());
}

TEST(JudgementJson, ListsCoverageTestsAndTheLawOfTheErrors) {
  Judgement judgement;
  judgement.coverage[2].pooled = {.inside = 7, .total = 9};
  judgement.tests = {{"NEES", Exactness::exact, 0.25, 0.5, "mean 2"}};
  judgement.sensors.resize(2);
  judgement.sensors[0].whiteness.autocorrelation = {0.5, -0.25};
  judgement.sensors[1].whiteness.autocorrelation = {9.0};
  judgement.law.energy_of_position = true;
  judgement.law.shape.shape.factors = Eigen::Vector2d(0.5, 2.0);
  const Json j = as_read(judgement_json(judgement));
  EXPECT_EQ(j["coverage"].size(), 3U);
  EXPECT_EQ(j["coverage"][2]["k_sigma"], 3.0);
  EXPECT_EQ(j["coverage"][2]["inside"], 7);
  EXPECT_EQ(j["tests"][0].dump(),
            R"({"name":"NEES","p_value":0.25,"adjusted_p_value":0.5,"law":"exact","measured":"mean 2"})");
  EXPECT_EQ(j["autocorrelation"].dump(), "[0.5,-0.25]") << "of the first sensor";
  EXPECT_EQ(j["scores"]["energy_of"], "position");
  EXPECT_EQ(j["shape"]["factors"].dump(), "[0.5,2.0]");
}

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
  const Json j = as_read(verdict_json(verdict));
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
  const Json j = as_read(verdict_json(judged({0.0, 0.0})));
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
  const Json j = as_read(verdict_json(verdict));
  EXPECT_TRUE(j["factor"]["upper"].is_null());
  EXPECT_TRUE(j["overall"]["upper"].is_null());
  EXPECT_EQ(text_of_json(j).find("inf"), std::string::npos);
}

TEST(VerdictJson, BoundsHaveThePValueOfTheirTest) {
  ConsistencyVerdict verdict = judged({3.0});
  EXPECT_EQ(verdict_json(verdict)["overall"]["p_value"], verdict.overall_p_value);
  verdict.bounds_p_value = 0.25;
  EXPECT_EQ(verdict_json(verdict)["overall"]["p_value"], 0.25);
}

TEST(VerdictJson, AWordHasWhatItJoins) {
  Word word;
  word.verdict = Verdict::optimistic;
  word.p_value = 0.001;
  word.says = "optimistic in heading";
  word.joined = {{"nees", Verdict::optimistic, 0.001}, {"nis", Verdict::undecided, std::nan("")}};
  const Json j = as_read(word_json(word));
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
