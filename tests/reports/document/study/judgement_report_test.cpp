#include "reports/document/study/judgement_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of which nothing is told of the law of the errors.
Judgement without_law() {
  Judgement judgement;
  judgement.law.equivalence.p_value = kNaN;
  judgement.law.second_moments.test.reason = "none";
  judgement.law.log_score.reason = "none";
  return judgement;
}

/// Sentences on runs that would settle a mean NEES of this share of the expected one.
std::vector<std::string> settling(double observed, double below, double above) {
  Judgement judgement = without_law();
  judgement.settle_nees = {
      .observed_factor = observed, .runs = 40, .detectable = {.below = below, .above = above}};
  return statistics_sentences(judgement);
}

TEST(StatisticsSentences, EveryPercentageIsOfOneKind) {
  // Factors of 0.8 and of 1.25 are both off by 25 %: one is the inverse of the other.
  EXPECT_THAT(
      settling(0.8, 0.8, 1.25),
      ElementsAre(
          "NEES: these runs would have revealed P too small by 25 % or too large by 25 %; to reveal the 25 % "
          "by which it looks too large would take 40 runs (power 90 %)."));
  EXPECT_THAT(
      settling(1.25, 0.5, 1.5).front(),
      HasSubstr("too small by 50 % or too large by 100 %; to reveal the 25 % by which it looks too small"));
}

TEST(StatisticsSentences, OneRunIsNotSeveral) {
  Judgement judgement = without_law();
  judgement.runs = 1;
  judgement.settle_nis = {.observed_factor = 0.8, .runs = 40, .detectable = {.below = 0.8, .above = 1.25}};
  EXPECT_THAT(statistics_sentences(judgement),
              ElementsAre(HasSubstr("NIS: this run would have revealed S too small by 25 %")));
}

TEST(StatisticsSentences, FactorsFarFromOneAreWrittenOut) {
  EXPECT_THAT(settling(1.05, 0.25, 4.0).front(), HasSubstr("too small by 300 % or too large by 300 %"));
  EXPECT_THAT(
      settling(1.05, 0.0, kInfinity).front(),
      HasSubstr("too small by more than a factor of ten or too large by more than a factor of ten; to"));
  EXPECT_THAT(settling(1.0049, 0.99, 1.0101).front(),
              HasSubstr("by 1 % or too large by 1 %; to reveal the 0.49 % by which it looks too small"));
}

// Of a large state the directions of its first block alone are looked at.
TEST(StatisticsSentences, SayOfWhatTheMeanSquaresAre) {
  Judgement judgement = without_law();
  SecondMomentJudgement& second = judgement.law.second_moments;
  second.test.reason = {};
  second.test.p_value = {.optimistic = 0.5, .pessimistic = 0.25};
  second.worst = "x with y";
  EXPECT_THAT(statistics_sentences(judgement).front(),
              HasSubstr("their mean squares over all rows agree with P (p"));
  second.of = "pose";
  EXPECT_THAT(statistics_sentences(judgement).front(),
              HasSubstr("agree with P of the block pose, the only one looked at in so large a state (p"));
}

TEST(StopSentence, SaysThatNoFactorFitsAllStepsInWords) {
  StudyAnalysis analysis;
  analysis.statistics.runs = 64;
  analysis.scenario.study.runs = 640;
  analysis.stop = StopDecision{.stop = true, .reason = "verdict", .verdict = Verdict::optimistic};
  analysis.stop->p_value = 0.001;
  analysis.stop->scale = {1.5, 2.0};
  EXPECT_EQ(stop_sentence(analysis),
            "Stopped by verdict after 64 of at most 640 runs: optimistic, however often one looked (p = "
            "0.00100); P "
            "times a factor from 1.50 to 2.00 agrees with what was seen.");
  analysis.stop->scale = {kNaN, kNaN};
  EXPECT_THAT(stop_sentence(analysis),
              HasSubstr("; no single factor on P agrees with what was seen at all steps."));
  analysis.timed_out = true;
  EXPECT_EQ(stop_sentence(analysis),
            "Out of time after 64 of at most 640 runs: optimistic so far, at any look p = 0.00100.");
}

TEST(StopSentence, SaysWhyTheAnswerIsAnotherOne) {
  StudyAnalysis a;
  a.stop = StopDecision{.stop = true, .reason = "verdict", .verdict = Verdict::consistent};
  a.word.verdict = Verdict::consistent;
  EXPECT_EQ(contradiction_of_stop(a), "");
  EXPECT_THAT(stop_sentence(a), Not(HasSubstr("All the same")));
  a.word.verdict = Verdict::mixed;
  a.word.says = "mixed";
  EXPECT_THAT(stop_sentence(a),
              HasSubstr("All the same: the rule proves the mean of NEES alone, and the filter is mixed"));
  a.word = {};
  a.word.verdict = Verdict::not_gaussian;
  a.word.says = "the errors have heavy tails";
  EXPECT_THAT(contradiction_of_stop(a), HasSubstr("the errors have heavy tails, for which"));
}

TEST(AdviceSentences, TheBlockResponsibleIsNamedWithItsNumbers) {
  Judgement judgement;
  judgement.word.verdict = Verdict::optimistic;
  judgement.scale_covariance.reason = "none";
  BlockVerdict heading{.name = "heading", .verdict = {}};
  heading.verdict.verdict = Verdict::optimistic;
  heading.verdict.mean = 3.25;
  heading.verdict.expected = 1.0;
  judgement.blocks = {heading};
  judgement.responsible.index = 0;
  EXPECT_THAT(
      advice_sentences(judgement),
      ElementsAre(
          "The inconsistency is clearest in the block “heading”, which is optimistic: mean NEES 3.250 where "
          "1.000 is expected."));
  judgement.responsible.index = -1;
  judgement.responsible.joint_only = true;
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre(HasSubstr("the correlations between blocks are wrong")));
  judgement.word.verdict = Verdict::not_gaussian;
  EXPECT_THAT(advice_sentences(judgement), IsEmpty()) << "P is right";
}

TEST(AdviceSentences, AFactorThatMayBeOneIsNoAdvice) {
  Judgement judgement;
  judgement.word.verdict = Verdict::pessimistic;
  judgement.scale_covariance = {.factor = 0.5, .lower = 0.25, .upper = 0.75};
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre("Scaling P by 0.500 (0.250 … 0.750) would make the mean NEES right."));
  judgement.nees.factor = {.mean = 0.5, .lower = 0.25, .upper = 0.75};
  judgement.nees.confidence = 0.95;
  judgement.blocks = {{.name = "pos", .verdict = judgement.nees}};
  judgement.blocks.front().verdict.factor = {.mean = 0.01, .lower = 0.005, .upper = 0.015};
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre("Scaling P by 0.500 (0.250 … 0.750) would make the mean NEES right but leave pos "
                          "pessimistic."));
  judgement.blocks.clear();
  judgement.scale_covariance.upper = 1.25;
  EXPECT_THAT(advice_sentences(judgement), IsEmpty());
  judgement.scale_covariance.upper = 0.75;
  judgement.word.verdict = Verdict::mixed;
  EXPECT_THAT(advice_sentences(judgement), IsEmpty())
      << "no factor suits what is larger here and smaller there";
  judgement.word.verdict = Verdict::consistent;
  judgement.nis.verdict = Verdict::optimistic;
  judgement.responsible.index = 0;
  judgement.blocks = {{.name = "pos", .verdict = judgement.nees}};
  EXPECT_THAT(advice_sentences(judgement), IsEmpty()) << "nothing is to be mended";
}

TEST(AdviceSentences, TheFirstSignIsToldWhereItComesLongBefore) {
  const auto block = [](const char* name, std::int64_t first) {
    BlockVerdict of{.name = name, .verdict = {}};
    of.verdict.verdict = Verdict::optimistic;
    of.verdict.steps.resize(100);
    of.verdict.steps_tested = 100;
    of.verdict.optimistic_steps = {.first = first, .last = 100, .count = 101 - first};
    return of;
  };
  Judgement judgement;
  judgement.word.verdict = Verdict::optimistic;
  judgement.scale_covariance.reason = "none";
  judgement.blocks = {block("map", 60), block("pose", 40)};
  judgement.tests = {{"NEES", Exactness::conservative, 1e-9, 1e-8, ""},
                     {"NEES of pose", Exactness::conservative, 0.001, 0.01, ""}};
  judgement.responsible.index = 0;
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre(HasSubstr("block “map”"), "It is seen first in pose, from step 40 on."));
  judgement.tests[1].adjusted = 0.09;
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("block “map”")))
      << "the pose fails by itself alone";
  judgement.nees = block("", 20).verdict;
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre(HasSubstr("block “map”"), "It is seen first in the whole state, from step 20 on."));
  judgement.nees = {};
  judgement.tests[1].adjusted = 0.01;
  judgement.blocks[1] = block("pose", 57);
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("block “map”")));
}

TEST(AdviceSentences, WhatBlocksShareIsNotPutDownToOneOfThem) {
  const auto optimistic = [](double mean, double expected) {
    ConsistencyVerdict v;
    v.verdict = Verdict::optimistic;
    v.mean = mean;
    v.expected = expected;
    return v;
  };
  Judgement judgement;
  judgement.word.verdict = Verdict::optimistic;
  judgement.scale_covariance.reason = "none";
  judgement.nees = optimistic(34.0, 15.0);
  judgement.blocks = {{"attitude", optimistic(3.5, 3.0)}, {"bias", optimistic(3.75, 3.0)}};
  judgement.responsible.index = 0;
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre("Most of the inconsistency is in what blocks share, the correlations between them: "
                          "mean NEES 34.00 of the whole state where 15.00 is expected. Of the blocks it is "
                          "clearest in “attitude”, which is optimistic: mean NEES 3.500 where 3.000 is "
                          "expected."));
  judgement.blocks[1].verdict.mean = 4.5;
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("is clearest in the block “attitude”")));
}

TEST(AdviceSentences, OfStepsThatDecidedTheMeanOverThemIsTold) {
  Judgement judgement;
  judgement.word.verdict = Verdict::optimistic;
  judgement.scale_covariance.reason = "none";
  BlockVerdict position{.name = "position", .verdict = {}};
  ConsistencyVerdict& v = position.verdict;
  v.verdict = Verdict::optimistic;
  v.mean = 2.125;
  v.expected = 2.0;
  v.decided_by_steps = true;
  v.optimistic_steps = {.first = 1, .last = 2, .count = 2};
  v.steps = {{.mean = 20.0, .count = 10, .total_dof = 20.0},
             {.mean = 14.0, .count = 10, .total_dof = 20.0},
             {.mean = 2.0, .count = 10, .total_dof = 20.0}};
  judgement.blocks = {position};
  judgement.responsible.index = 0;
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre(HasSubstr("mean NEES 2.125 where 2.000 is expected; in steps 1 to 2 it is 17.00 of "
                                    "2.000.")));
  judgement.blocks[0].verdict.decided_by_steps = false;
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("in steps 1 to 2 it is 17.00")));
  judgement.blocks[0].verdict.optimistic_steps = {.first = 1, .last = 1, .count = 1};
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(Not(HasSubstr("at step")))) << "by chance";
  judgement.blocks[0].verdict.optimistic_steps = {.first = 1, .last = 3, .count = 2};
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(Not(HasSubstr("in steps")))) << "these are all";
}

// NIS is too small and NEES too large: what mends the one makes the other worse.
TEST(AdviceSentences, OfWhatIsMixedTheSideWithoutACauseIsTold) {
  Judgement judgement;
  judgement.word.verdict = Verdict::mixed;
  judgement.nees.verdict = Verdict::optimistic;
  judgement.nis.verdict = Verdict::pessimistic;
  judgement.scale_covariance.reason = "none";
  judgement.scale_innovation = {.factor = 0.5, .lower = 0.4, .upper = 0.6};
  judgement.causes = {{Cause::measurement_noise_too_large, "NIS is 0.5"}};
  EXPECT_THAT(
      advice_sentences(judgement),
      ElementsAre(
          HasSubstr("Likely cause"),
          "That explains only where it is pessimistic: of where it is optimistic no cause was found."));
  EXPECT_THAT(advice_sentences(judgement, Verdict::optimistic), ElementsAre(HasSubstr("Likely cause")))
      << "which is said elsewhere";
  judgement.causes.push_back({Cause::bias, "a mean"});
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("too large"), HasSubstr("bias")));
  judgement.causes = {{Cause::initial_covariance, "the first NEES"}};
  EXPECT_THAT(advice_sentences(judgement), ElementsAre(HasSubstr("initial covariance")));
}

TEST(AdviceSentences, OfSeveralSensorsEachThatIsWrongHasItsFactor) {
  Judgement judgement;
  judgement.word.verdict = judgement.nis.verdict = Verdict::pessimistic;
  judgement.scale_covariance.reason = "none";
  judgement.scale_innovation = {.factor = 0.77, .lower = 0.7, .upper = 0.8};
  judgement.scale_measurement_noise.reason = "none";
  ConsistencyVerdict wrong, right;
  wrong.verdict = Verdict::pessimistic;
  wrong.mean = 1.316;
  wrong.expected = 2.0;
  right.verdict = Verdict::consistent;
  right.mean = right.expected = 1.0;
  judgement.sensors = {{.name = "gps", .nis = wrong}, {.name = "baro", .nis = right}};
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre("Scaling S of gps by 0.658 would make its mean NIS right."));
  judgement.sensors.pop_back();
  EXPECT_THAT(advice_sentences(judgement),
              ElementsAre("Scaling S by 0.770 (0.700 … 0.800) would make the mean NIS right."));
}

TEST(TestsTable, ATestFailsAloneUnlessHolmRejectsItToo) {
  Judgement judgement;
  judgement.confidence = 0.95;
  judgement.tests = {{"a", Exactness::exact, 1e-9, 1e-8, ""},
                     {"b", Exactness::exact, 0.02, 0.2, ""},
                     {"c", Exactness::exact, 0.5, 1.0, ""},
                     {"d", Exactness::exact, kNaN, kNaN, "no data"}};
  std::vector<std::string> says;
  for (const auto& row : tests_table(judgement).rows) says.push_back(row[4].text);
  EXPECT_THAT(says, ElementsAre("fails", "fails alone", "passes", "not tested"));
  EXPECT_EQ(tests_table(judgement).rows[3][2].text, "–");
}

TEST(TestsTable, ARowThatSaysNothingIsExplained) {
  Judgement judgement;
  judgement.tests = {{"coverage of 1σ", Exactness::conservative, 1.0, 1.0, ""}};
  judgement.coverage.front().expected = 0.5;
  judgement.coverage.front().tests = 1;
  judgement.coverage.front().pooled = {.inside = 2, .total = 2};
  judgement.coverage.front().steps = {{.count = {.inside = 2, .total = 2}, .expected = 0.5}};
  EXPECT_EQ(tests_table(judgement).rows[0].back().text, "says nothing here");
  EXPECT_THAT(tests_table(judgement).notes, Contains(StartsWith("says nothing here: of so few runs")));
  judgement.coverage.front().steps.front().count = {.inside = 20, .total = 20};
  EXPECT_EQ(tests_table(judgement).rows[0].back().text, "passes");
  EXPECT_EQ(tests_table(judgement).notes.size(), 2U);
}

TEST(ExactSentence, AFactorOfOneMendsNothing) {
  StudyAnalysis analysis;
  analysis.exact = {{.nees = 4.0, .nees_dof = 2, .nis = 1.0, .nis_dof = 1}};
  EXPECT_EQ(exact_sentence(analysis),
            "Exact, without sampling noise: mean NEES 4.000 of 2.000 (scaling P by 2.000 would make it "
            "right), mean NIS 1.000 of 1.000.");
  analysis.exact.front().nees = 2.0;
  EXPECT_EQ(exact_sentence(analysis),
            "Exact, without sampling noise: mean NEES 2.000 of 2.000, mean NIS 1.000 of 1.000.");
}

TEST(AccuracyTable, AnglesAreInDegreesAndEfficiencyIsOfSquares) {
  BlockAccuracy heading;
  heading.of = "heading";
  heading.unit = "rad";
  const double degree = std::numbers::pi / 180.0;
  heading.squared_error = {
      .mean = 4.0 * degree * degree, .lower = degree * degree, .upper = 9.0 * degree * degree, .count = 20};
  heading.claimed = 25.0 * degree * degree;
  heading.bound = heading.at_truth = kNaN;
  Judgement judgement = without_law();
  judgement.accuracy = {heading};
  const auto texts = [&](const PosteriorBound* bound) {
    std::vector<std::string> all;
    const ReportTable table = accuracy_table(judgement, bound);
    for (const TableCell& cell : table.rows.at(0)) all.push_back(cell.text);
    return all;
  };
  EXPECT_THAT(texts(nullptr), ElementsAre("heading (°)", "2.00 (1.00 … 3.00)", "5.00"));
  judgement.accuracy[0].bound = degree * degree;
  judgement.accuracy[0].at_truth = 1.21 * degree * degree;
  const PosteriorBound bound;
  EXPECT_THAT(texts(&bound), ElementsAre("heading (°)", "2.00 (1.00 … 3.00)", "5.00", "1.10", "1.00",
                                         "0.250 (0.111 … 1.00)"));
  EXPECT_THAT(accuracy_table(judgement, &bound).notes, Not(Contains(HasSubstr("loose"))))
      << "1/1.21 is above 0.8";
  judgement.accuracy[0].squared_error.lower = judgement.accuracy[0].squared_error.upper = kNaN;  // of one run
  EXPECT_EQ(texts(nullptr)[1], "2.00");
  EXPECT_THAT(
      statistics_sentences(judgement),
      Contains(
          "RMSE beside P and the posterior Cramér-Rao bound: heading (°) 2.00, P claims 5.00, bound 1.00."));
  judgement.accuracy[0].claimed = kNaN;  // of a store of an earlier format
  EXPECT_EQ(texts(nullptr)[2], "–");
  EXPECT_THAT(statistics_sentences(judgement),
              Contains("RMSE beside P and the posterior Cramér-Rao bound: heading (°) 2.00, bound 1.00."));
  judgement.accuracy[0].claimed = 25.0 * degree * degree;
  judgement.accuracy[0].at_truth = 1.3 * degree * degree;
  EXPECT_THAT(accuracy_table(judgement, &bound).notes, Contains(HasSubstr("loose")));
  EXPECT_THAT(statistics_sentences(judgement),
              Contains(HasSubstr("P claims 5.00, with Jacobians at the truth 1.14, bound 1.00 (loose).")))
      << "√1.3";
}

// The average of those that are left lay below a bound, with nothing to say why.
TEST(AccuracyTable, SaysWhenRunsThatFailedAreLeftOut) {
  Judgement judgement = without_law();
  judgement.accuracy = {{.of = "position",
                         .unit = "m",
                         .squared_error = {.mean = 4.0, .lower = kNaN, .upper = kNaN, .count = 7},
                         .claimed = 4.0,
                         .at_truth = 9.0,
                         .bound = 9.0}};
  judgement.runs = 7;
  const PosteriorBound bound;
  EXPECT_THAT(accuracy_table(judgement, &bound).notes, Not(Contains(HasSubstr("did not fail"))));
  judgement.runs = 12;
  const std::string note =
      "Only the 7 of 12 runs that did not fail are averaged: the errors of the others may be the largest";
  EXPECT_THAT(accuracy_table(judgement).notes, Contains(note + "."));
  EXPECT_THAT(accuracy_table(judgement, &bound).notes,
              Contains(note + ", and an efficiency above 1 is then no merit."));
  EXPECT_THAT(statistics_sentences(judgement),
              Contains("RMSE beside P and the posterior Cramér-Rao bound, of the 7 of 12 runs that did not "
                       "fail: position (m) 2.00, P claims 2.00, bound 3.00."));
}

TEST(AccuracyTable, HasTheUnitOfTheLayout) {
  Judgement judgement = without_law();
  judgement.accuracy = {{.of = "position", .unit = "m"},
                        {.of = "place", .unit = "km"},
                        {.of = "velocity", .unit = "m/s"},
                        {.of = "gyro_bias", .unit = "rad/s"},
                        {.of = "mixed"}};
  const double degree = std::numbers::pi / 180.0;
  for (BlockAccuracy& row : judgement.accuracy) {
    const double scale = row.of == "gyro_bias" ? degree : 1.0;
    row.squared_error = {
        .mean = 4.0 * scale * scale, .lower = scale * scale, .upper = 9.0 * scale * scale, .count = 20};
    row.claimed = row.bound = row.at_truth = 25.0 * scale * scale;
  }
  const ReportTable table = accuracy_table(judgement);
  std::vector<std::string> names;
  for (const auto& row : table.rows) {
    names.push_back(row.at(0).text);
    EXPECT_EQ(row.at(1).text, "2.00 (1.00 … 3.00)") << names.back();
    EXPECT_EQ(row.at(2).text, "5.00") << names.back();
  }
  EXPECT_THAT(names, ElementsAre("position (m)", "place (km)", "velocity (m/s)", "gyro_bias (°/s)", "mixed"));
  EXPECT_THAT(statistics_sentences(judgement),
              Contains(HasSubstr("velocity (m/s) 2.00 (1.00 … 3.00), P claims 5.00, bound 5.00")));
}

TEST(EvidenceFigure, TheBarsOfTheHistogramHaveTheDensityOfWhatWasCounted) {
  Judgement judgement;
  SensorJudgement& sensor = judgement.sensors.emplace_back();
  sensor.fit.count = 640;
  sensor.histogram.assign(64, 0);
  sensor.histogram[0] = 100;  // in the first of 32 bars
  sensor.histogram[1] = 60;
  sensor.histogram[63] = 480;
  sensor.whiteness.reason = "none";
  const Figure figure = evidence_figure("x", judgement);
  ASSERT_EQ(figure.panels.size(), 1U);
  const Series& expected = figure.panels[0].series.at(0);
  const Series& bars = figure.panels[0].series.at(1);
  ASSERT_EQ(bars.y.size(), 33U) << "the last step ends at 1";
  EXPECT_DOUBLE_EQ(bars.y[0], 160.0 / 640.0 * 32.0);
  EXPECT_EQ(bars.y[1], 0.0);
  EXPECT_DOUBLE_EQ(bars.y[31], 480.0 / 640.0 * 32.0);
  // A bar of a uniform law holds Binomial(640, 1/32): its density has variance 32² (1/32) (31/32) / 640.
  EXPECT_NEAR(expected.upper[0] - 1.0, 2.0 * std::sqrt(31.0 / 640.0), 1e-12);
  EXPECT_NO_THROW(validate(figure));
}

/// A sensor with both panels, of a mean NIS of so much where 1 is expected.
SensorJudgement seen_sensor(const std::string& name, double nis, Verdict verdict) {
  SensorJudgement sensor{.name = name};
  sensor.fit.count = 64;
  sensor.fit.anderson_p_value = 0.5;
  sensor.histogram.assign(64, 1);
  sensor.whiteness.autocorrelation = {0.25};
  sensor.whiteness.band = {0.5};
  sensor.whiteness.p_value = 0.5;
  sensor.nis.mean = nis;
  sensor.nis.expected = 1.0;
  sensor.nis.dof = 100.0;
  sensor.nis.p_value = 0.0;
  sensor.nis.verdict = verdict;
  return sensor;
}

TEST(EvidenceFigure, OfManySensorsTheWorstAreShownAndThatIsSaid) {
  Judgement judgement;
  judgement.runs = 8;
  for (int i = 0; i < 12; ++i)
    judgement.sensors.push_back(seen_sensor("s" + std::to_string(i), 1.0, Verdict::consistent));
  judgement.sensors[7] = seen_sensor("s7", 3.0, Verdict::optimistic);
  judgement.sensors[9] = seen_sensor("s9", 9.0, Verdict::optimistic);
  judgement.sensors[10].whiteness.p_value = 1e-9;
  const Figure figure = evidence_figure("x", judgement);
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 6U);
  EXPECT_EQ(figure.panels[0].title.text, "NIS against its law: s9");
  EXPECT_EQ(figure.panels[2].title.text, "NIS against its law: s7");
  EXPECT_EQ(figure.panels[5].title.text, "Whiteness: s10");
  EXPECT_THAT(figure.caption, EndsWith(" Of 12 sensors 3 are shown, inconsistent ones first."));
  judgement.sensors.resize(3);
  const Figure all = evidence_figure("x", judgement);
  EXPECT_EQ(all.panels[0].title.text, "NIS against its law: s0");
  EXPECT_THAT(all.caption, Not(HasSubstr("are shown")));
}

TEST(EvidenceFigure, TheCaptionSaysWhatIsShown) {
  Judgement judgement;
  judgement.runs = 2;
  judgement.sensors.push_back(seen_sensor("s", 1.0, Verdict::consistent));
  const Figure of_innovations = evidence_figure("x", judgement);
  EXPECT_EQ(of_innovations.panels.at(1).y_label.text, "autocorrelation of innovation");
  EXPECT_EQ(of_innovations.caption,
            "Further tests, over 2 runs: the values of NIS taken through their distribution function, which "
            "makes them uniform; the correlation of the normalised innovation with itself in time.");
  const Sensor nis_alone{.name = "s", .nis_alone = true};
  const Figure of_nis = evidence_figure("x", judgement, {&nis_alone, 1});
  EXPECT_EQ(of_nis.panels.at(1).y_label, figure_markup("autocorrelation of Φ^{−1}(F(NIS))"));
  EXPECT_THAT(of_nis.caption, Not(HasSubstr("innovation")));
  judgement.sensors[0].whiteness.reason = "none";
  EXPECT_THAT(evidence_figure("x", judgement).caption, Not(HasSubstr("correlation")));
}

/// Of 100 runs over four steps; so much of the truth is expected within 1, 2 and 3σ at each of them.
Judgement judgement_of_coverage(const std::vector<std::array<double, 3>>& expected) {
  Judgement judgement;
  judgement.runs = 100;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const auto& step : expected) {
      judgement.coverage[i].steps.push_back({.count = {.inside = 50, .total = 100},
                                             .interval = {.value = 0.5, .lower = 0.4, .upper = 0.6},
                                             .expected = step.at(i)});
    }
    judgement.coverage[i].tests = std::ssize(expected);
  }
  return judgement;
}

TEST(EvidenceFigure, WhatIsExpectedWithinSoManySigmaHasTheColourOfWhatWasMeasured) {
  const Figure figure =
      evidence_figure("x", judgement_of_coverage(std::vector<std::array<double, 3>>(4, {0.09, 0.59, 0.94})));
  ASSERT_EQ(figure.panels.size(), 1U);
  EXPECT_EQ(figure.caption,
            "Further tests, over 100 runs: how often the truth lies within kσ of the whole state.");
  const std::vector<Series>& series = figure.panels[0].series;
  ASSERT_EQ(series.size(), 6U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Series &expected = series[2 * i], &measured = series[2 * i + 1];
    EXPECT_EQ(measured.label.text, fmt::format("{}σ", i + 1));
    EXPECT_EQ(expected.label.text, measured.label.text + " expected");
    EXPECT_EQ(expected.role, measured.role);
    EXPECT_EQ(expected.stroke, StrokeStyle::dashed);
  }
  EXPECT_EQ(series[4].y[0], 94.0);
  EXPECT_EQ(series[5].y[0], 50.0);
}

TEST(EvidenceFigure, ARegionThatHoldsTheTruthAtFewStepsAloneIsNotShown) {
  const std::array<double, 3> few_states{0.2, 0.7, 0.97}, many{0.0, 0.0, 0.004};
  EXPECT_TRUE(evidence_figure("x", judgement_of_coverage({few_states, many, many, many})).panels.empty());
  EXPECT_EQ(evidence_figure("x", judgement_of_coverage({few_states, few_states, many, many})).panels.size(),
            1U);
}

}  // namespace
}  // namespace credence::internal
