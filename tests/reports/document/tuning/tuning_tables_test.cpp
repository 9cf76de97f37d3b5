#include "reports/document/tuning/tuning_tables.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

std::vector<std::string> texts_of(const std::vector<TableCell>& row) {
  std::vector<std::string> texts;
  for (const TableCell& cell : row) texts.push_back(cell.text);
  return texts;
}

/// Of three numbers one is found, one is bounded from above, and of one nothing is known.
Tuning one_of_three() {
  Tuning tuning;
  tuning.parameters = {{.name = "filter.Q[1,1]",
                        .before = 0.3,
                        .value = 0.1,
                        .lower = 0.08,
                        .upper = 0.125,
                        .bootstrap_lower = 0.07,
                        .bootstrap_upper = 0.14,
                        .identifiable = true,
                        .steps_for_10_percent = 2761.6},
                       {.name = "filter.Q[2,2]",
                        .before = 1.0,
                        .lower = 0.0,
                        .upper = 2.5,
                        .reason = "its interval is too wide"},
                       {.name = "filter.R[1,1]", .before = 2.0, .reason = "it has no effect"}};
  tuning.coordinates = {"filter.Q[1,1]"};
  tuning.correlation = Matrix::Identity(1, 1);
  tuning.likelihood_ratio = 31.25;
  tuning.likelihood_ratio_dof = 2;
  tuning.likelihood_ratio_p_value = 2.3e-8;
  tuning.nis_before = 1.5;
  tuning.nis_after = 1.0;
  tuning.dof = 1.0;
  return tuning;
}

TEST(TuningTables, ANumberThatWasNotFoundHasItsLimitsOrItsReason) {
  const ReportTable table = tuned_noise_table("level", "engine", one_of_three());
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_THAT(texts_of(table.rows[0]), ElementsAre("filter.Q[1,1]", "0.3000", "0.1000", "0.08000 … 0.1250",
                                                   "0.07000 … 0.1400", "2762"));
  EXPECT_THAT(texts_of(table.rows[1]), ElementsAre("filter.Q[2,2]", "1.000", "not identifiable",
                                                   "only within 0.000 … 2.500", "–", "–"));
  EXPECT_THAT(texts_of(table.rows[2]),
              ElementsAre("filter.R[1,1]", "2.000", "not identifiable", "it has no effect", "–", "–"));
  EXPECT_EQ(table.rows[1][2].tone, CellTone::caution);
  EXPECT_EQ(table.rows[0][2].tone, CellTone::plain);
}

TEST(TuningTables, TheDocumentSaysNullWithItsReasonAndNeverInfinity) {
  Tuning tuning = one_of_three();
  tuning.parameters[1].upper = kNoLimit;
  const Json j = as_read(tuning_json(tuning));
  const Json &found = j["parameters"][0], &bounded = j["parameters"][1];
  EXPECT_EQ(found["value"], 0.1);
  EXPECT_EQ(found["bootstrap"]["upper"], 0.14);
  EXPECT_FALSE(found.contains("null_reason"));
  EXPECT_TRUE(bounded["value"].is_null());
  EXPECT_EQ(bounded["lower"], 0.0);
  EXPECT_TRUE(bounded["upper"].is_null());
  EXPECT_EQ(bounded["null_reason"], "its interval is too wide");
  EXPECT_EQ(j["innovations"]["nis"]["before"], 1.5);
  EXPECT_EQ(j["innovations"]["nis"]["after"], 1.0);
  EXPECT_TRUE(j["log_score"]["before"].is_null());
  EXPECT_EQ(j["intervals"], "observed information");
  tuning.by_sandwich = true;
  EXPECT_EQ(tuning_json(tuning)["intervals"], "sandwich");
  EXPECT_THAT(tuned_noise_table("", "", tuning).notes.front(), HasSubstr("sandwich"));
}

TEST(TuningTables, ALimitThatExcludesThePresentValueIsAskedFor) {
  Tuning bounded = one_of_three();
  bounded.parameters[1].upper = 0.0479;
  EXPECT_EQ(asked_noise_text("They", bounded),
            "They ask for filter.Q[1,1] = 0.1000 (0.08000 … 0.1250), filter.Q[2,2] of at most 0.0479");
  bounded.parameters[0].before = 0.1;
  EXPECT_EQ(
      asked_noise_text("They", bounded),
      "They ask for filter.Q[2,2] of at most 0.0479 and agree with the present value in filter.Q[1,1] = "
      "0.1000 (0.08000 … 0.1250)");
  bounded.parameters[1].lower = 3.5;
  bounded.parameters[1].upper = kNoLimit;
  EXPECT_THAT(asked_noise_text("They", bounded), HasSubstr("filter.Q[2,2] of at least 3.50 and"));
  EXPECT_THAT(likelihood_ratio_text(bounded), HasSubstr("31.25 with 2 dof"));
}

TEST(TuningTables, TheDataAskForWhatTheirIntervalExcludes) {
  EXPECT_EQ(asked_noise_text("They", one_of_three()),
            "They ask for filter.Q[1,1] = 0.1000 (0.08000 … 0.1250)");
  Tuning two = one_of_three();
  two.parameters[2] = {
      .name = "r", .before = 1.5, .value = 2.0, .lower = 1.0, .upper = kNoLimit, .identifiable = true};
  EXPECT_EQ(
      asked_noise_text("They", two),
      "They ask for filter.Q[1,1] = 0.1000 (0.08000 … 0.1250) and agree with the present value in r = 2.000 "
      "(1.000 … ∞)");
  two.parameters[0].before = 0.12;
  EXPECT_EQ(asked_noise_text("They", two),
            "They ask for filter.Q[1,1] = 0.1000 (0.08000 … 0.1250), r = 2.000 (1.000 … ∞)")
      << "together, by the likelihood ratio";
  two.likelihood_ratio_p_value = 0.4;
  EXPECT_EQ(asked_noise_text("They", two),
            "They agree with the present noise; most likely is filter.Q[1,1] = 0.1000 (0.08000 … 0.1250), r "
            "= 2.000 "
            "(1.000 … ∞)");
}

TEST(TuningTables, AnIntervalOfTheLikelihoodRatioIsSaidToBeOne) {
  Tuning tuning = one_of_three();
  EXPECT_THAT(tuned_noise_table("", "", tuning).notes.front(), Not(HasSubstr("likelihood ratio")));
  tuning.parameters[0].by_likelihood_ratio = true;
  EXPECT_THAT(tuned_noise_table("", "", tuning).notes.front(), HasSubstr("likelihood ratio"));
  EXPECT_EQ(tuning_json(tuning)["parameters"][0]["by_likelihood_ratio"], true);
}

TEST(TuningTables, WhereNothingIsFoundTheLastSentenceSaysWhy) {
  Tuning tuning;
  EXPECT_EQ(nothing_told(tuning).text, "Nothing could be told");
  EXPECT_EQ(nothing_told(tuning).tone, CellTone::caution);
  tuning.notes = {"First.", "Q is held: these data do not determine it."};
  EXPECT_EQ(nothing_told(tuning).text, "Q is held: these data do not determine it");
}

TEST(TuningTables, ALikelihoodRatioIsAStatementOfItsPValue) {
  Tuning tuning = one_of_three();
  EXPECT_EQ(likelihood_ratio_text(tuning), "Likelihood ratio 31.25 with 2 dof, p = 2.30e−8.");
  tuning.by_sandwich = true;
  EXPECT_THAT(likelihood_ratio_text(tuning),
              HasSubstr("2 dof, divided by how much more the scores vary, p = "));
  tuning.likelihood_ratio_p_value = 1e-40;
  EXPECT_THAT(likelihood_ratio_text(tuning), HasSubstr("scores vary, p < 1e"));
}

TEST(TuningTables, TheForecastTellsPercentFromShare) {
  TuningForecast forecast;
  forecast.steps = 15000.0;
  forecast.parameters = {
      {.name = "Q", .identifiable = true, .relative_error = 0.0425, .steps_for_10_percent = 2709.4},
      {.name = "R", .reason = "it has no effect"}};
  const ReportTable table = tune_forecast_table(forecast);
  EXPECT_THAT(texts_of(table.rows.at(0)), ElementsAre("Q", "4.25 %", "2709", ""));
  EXPECT_THAT(texts_of(table.rows.at(1)), ElementsAre("R", "–", "–", "it has no effect"));
  EXPECT_EQ(table.columns.back().title, "held, because");
  EXPECT_THAT(table.notes.at(0), HasSubstr("15000 steps"));
  Tuning tuning;
  tuning.forecast = forecast;
  const Json j = as_read(tuning_json(tuning))["forecast"];
  EXPECT_EQ(j[0]["relative_error"], 0.0425);
  EXPECT_TRUE(j[1]["steps_for_10_percent"].is_null());
  EXPECT_EQ(j[1]["null_reason"], "it has no effect");
  EXPECT_FALSE(j[0].contains("null_reason"));
}

TEST(TuningTables, AForecastOfWhatIsAllFoundHasNoColumnOfReasons) {
  TuningForecast forecast;
  forecast.parameters = {
      {.name = "Q", .identifiable = true, .relative_error = 0.0425, .steps_for_10_percent = 2709.4}};
  const ReportTable table = tune_forecast_table(forecast);
  EXPECT_EQ(table.columns.size(), 3U);
  EXPECT_THAT(texts_of(table.rows.at(0)), ElementsAre("Q", "4.25 %", "2709"));
}

// "3186 %" and "2029704549" were shown of what is not known at all.
TEST(TuningTables, ElementsOfARootAreExplainedAndWhatIsNotKnownIsNotWrittenOut) {
  TuningForecast forecast;
  forecast.parameters = {{.name = "L_Q[2,1]",
                          .identifiable = true,
                          .relative_error = 31.86,
                          .steps_for_10_percent = 2029704549.0}};
  const ReportTable table = tune_forecast_table(forecast);
  EXPECT_THAT(texts_of(table.rows.at(0)), ElementsAre("L_Q[2,1]", "> 100 %", "2.03e9"));
  EXPECT_THAT(table.notes,
              testing::Contains("L_Q: the lower triangle L of Q = L Lᵀ, which is searched over."));
  EXPECT_THAT(table.notes, Not(testing::Contains(HasSubstr("L_R"))));
  Tuning tuning = one_of_three();
  EXPECT_THAT(tuned_noise_table("", "", tuning).notes, Not(testing::Contains(HasSubstr("L_Q"))));
  tuning.forecast = forecast;
  EXPECT_THAT(tuned_noise_table("", "", tuning).notes, testing::Contains(HasSubstr("L_Q: ")));
}

TEST(TuningTables, AParameterHasTheUnitOfItsKey) {
  EXPECT_EQ(tuned_name("noise.speed_std"), "noise.speed_std (m/s)");
  EXPECT_EQ(tuned_name("noise.bearing_std_deg"), "noise.bearing_std_deg (°)");
  EXPECT_EQ(tuned_name("filter.process_scale"), "filter.process_scale");
  EXPECT_EQ(tuned_name("filter.Q[1,1]"), "filter.Q[1,1]");
  EXPECT_EQ(tuned_name("gps"), "gps");
}

// The information of a factor on Q = 1e-12 beside R = 1 falls with the square of their ratio.
TEST(TuningTables, StepsBeyondAnyWholeNumberAreStillANumber) {
  TuningForecast forecast;
  forecast.parameters = {
      {.name = "Q", .identifiable = true, .relative_error = 1.2e9, .steps_for_10_percent = 1.4e23}};
  EXPECT_EQ(tune_forecast_table(forecast).rows.at(0).at(2).text, "1.40e23");
  Tuning tuning = one_of_three();
  tuning.parameters[0].steps_for_10_percent = 1.4e23;
  EXPECT_EQ(tuned_noise_table("", "", tuning).rows.at(0).at(5).text, "1.40e23");
  tuning.parameters[0].steps_for_10_percent = 123456789.0;
  EXPECT_THAT(tuned_noise_table("", "", tuning).rows.at(0).at(5).text, Not(HasSubstr("−")));
}

TEST(TuningTables, BeforeAndAfterStandInTheirColumns) {
  Tuning tuning = one_of_three();
  tuning.score_before = -1.5;
  tuning.score_after = -1.25;
  tuning.lag_one_before = -0.2;
  const ReportTable table = score_gain_table(tuning);
  EXPECT_THAT(texts_of(table.rows.at(0)), ElementsAre(testing::_, "−1.50000", "−1.25000"));
  EXPECT_THAT(texts_of(table.rows.at(1)), ElementsAre("mean NIS (expected 1.000)", "1.500", "1.000"));
  EXPECT_THAT(texts_of(table.rows.at(2)), ElementsAre(testing::_, "−0.20", "–"));
}

}  // namespace
}  // namespace credence::internal
