#include "reports/document/tuning/tune_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "montecarlo/scenario/scenario_io.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

ScenarioTuning tuned(const std::string& filter, TuneRequest request = {},
                     const std::string& name = "wanderer") {
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[0.04]]\nR = [[1]]\n"
      "P0 = [[1]]\nstates = [\"x\"]\n[study]\nruns = 40\nsteps = 40\nseed = 7\n[filter]\n" +
          filter,
      name);
  request.threads = 1;
  return *tune_scenario(scenario, request);
}

/// A position that wanders, seen in noise; the filter believes a tenth of Q.
const ScenarioTuning& wanderer() {
  static const ScenarioTuning tuning = tuned("process_scale = 0.1\n");
  return tuning;
}

const Document& document_of_wanderer() {
  static const Document document = tune_document(tuned("process_scale = 0.1\n"));
  return document;
}

TEST(TuneReport, TheTunedScenarioIsTheOneOfTheFile) {
  EXPECT_EQ(load_scenario_text(tuned_toml(wanderer()), "wanderer"), wanderer().tuned);
}

// The name of a file is that of its scenario, and may hold a line's end.
TEST(TuneReport, ANameOfSeveralLinesIsNoPartOfTheTunedScenario) {
  const ScenarioTuning tuning = tuned("process_scale = 0.1\n", {}, "a\n[study]\nruns");
  EXPECT_EQ(load_scenario_text(tuned_toml(tuning), tuning.scenario.name), tuning.tuned);
}

TEST(TuneReport, FreshNoiseIsToldOfThePresentFilterAndOfTheTunedOne) {
  const ScenarioTuning& t = wanderer();
  const Document& document = document_of_wanderer();
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["runs"], 40);
  EXPECT_EQ(j["held_out"]["seed"], 8);
  EXPECT_EQ(j["held_out"]["runs"], 40);
  EXPECT_EQ(j["held_out"]["nees"]["mean"], t.held_out->after.nees.mean);
  EXPECT_EQ(j["held_out"]["before"]["nees"]["mean"], t.held_out->before.nees.mean);
  EXPECT_EQ(j["held_out"]["detectable"]["below"], t.held_out->detectable.below);
  EXPECT_EQ(j["held_out"]["detectable"]["above"], t.held_out->detectable.above);
  // Of a linear filter with the right noise ln N(0; P) in the mean: −½ (ln 2πP + NEES).
  EXPECT_GT(j["held_out"]["state_log_score"].get<double>(),
            j["held_out"]["before"]["state_log_score"].get<double>());
  EXPECT_LT(j["held_out"]["before"]["whiteness_p_value"].get<double>(), 1e-6);
  const ReportTable table = table_of(document, "Before and after");
  ASSERT_EQ(table.rows.size(), 8U);
  EXPECT_EQ(table.rows[3][1].text, "optimistic");
  EXPECT_EQ(table.rows[3][2].text, "consistent");
  EXPECT_EQ(table.rows[5][1].text, TableCell(t.held_out->before.nees.mean).text);
  EXPECT_EQ(table.rows[5][2].text, TableCell(t.held_out->after.nees.mean).text);
  EXPECT_THAT(table.notes.at(0), HasSubstr("40 runs of seed 8"));
  EXPECT_EQ(document.answer.tone, CellTone::good);
  EXPECT_THAT(document.answer.text, StartsWith("The innovations ask for filter.process_scale = "));
}

TEST(TuneReport, WhereFreshNoiseRefusesTheTunedNoiseItsErrorIsTold) {
  ScenarioTuning refused = tuned("process_scale = 0.1\n");
  refused.held_out->after.word.verdict = Verdict::optimistic;
  const auto notes = [](const Document& document) {
    return nlohmann::json::parse(document.json())["notes"].dump();
  };
  const auto told = HasSubstr("Tuned noise has an error of its own");
  EXPECT_THAT(notes(document_of_wanderer()), testing::Not(told));
  EXPECT_THAT(notes(tune_document(std::move(refused))), told);
}

// The loss of a point of the ridge against the log likelihood of the scenario with its values, played anew.
TEST(TuneReport, ARidgePointIsAScenarioThatScoresWorseByItsLoss) {
  const ScenarioTuning& t = wanderer();
  const auto j = nlohmann::json::parse(document_of_wanderer().json());
  ASSERT_EQ(j["ridge"].size(), t.ridge.size());
  ASSERT_FALSE(t.ridge.empty());
  const auto score_of = [](const Scenario& scenario) {
    const auto score = make_scenario_score(scenario, TuneRequest{}.free, 1);
    const UnitScores scores = score->model().scores(score->start(), false);
    return std::pair{scores.sum() / scores.steps, scores.lag_one_correlation()};
  };
  const double best = score_of(t.tuned).first;
  for (const auto& point : j["ridge"]) {
    Scenario scenario = t.scenario;
    scenario.filter.process_scale = point["values"]["filter.process_scale"];
    scenario.filter.measurement_scale = point["values"]["filter.measurement_scale"];
    const auto [score, lag_one] = score_of(scenario);
    EXPECT_NEAR(point["log_score_loss"].get<double>(), best - score, 1e-9);
    EXPECT_NEAR(point["lag_one_correlation"].get<double>(), lag_one, 1e-9);
    EXPECT_GT(best - score, 1e-4);
  }
  EXPECT_THAT(j["notes"].back(), StartsWith("NIS alone cannot tell these from the tuned noise"));
}

TEST(TuneReport, WhereNothingIsKnownThereIsNoScenarioAndNoFigure) {
  // Without process noise in the world and of one sensor: Q is only bounded from above.
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[0]]\nR = [[1]]\nP0 = [[1]]\n"
      "states = [\"x\"]\n[filter]\nQ = [[0.01]]\n[study]\nruns = 1\nsteps = 50\n",
      "still");
  const Document document = tune_document(
      *tune_scenario(scenario, TuneRequest{.free = {{NoiseMatrix::Q, NoiseForm::factor}}, .threads = 1}));
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_TRUE(j["held_out"].is_null());
  EXPECT_TRUE(j["ridge"].empty());
  EXPECT_TRUE(j["parameters"][0]["value"].is_null());
  EXPECT_EQ(table_of(document, "Before and after").rows.size(), 3U);
  for (const DocumentPart& part : document.parts()) {
    EXPECT_FALSE(std::holds_alternative<part::DrawnFigure>(part));
    if (const auto* heading = std::get_if<part::Heading>(&part)) EXPECT_NE(heading->title, "Tuned scenario");
  }
}

TEST(TuneReport, TheFiguresAreThoseOfWhatIsFree) {
  EXPECT_EQ(figure_of(document_of_wanderer(), "profiles").panels.size(), 2U);
  const Document of_one =
      tune_document(tuned("process_scale = 0.1\n", {.free = {{NoiseMatrix::R, NoiseForm::factor}}}));
  EXPECT_EQ(figure_of(of_one, "profiles").panels.size(), 1U);
  EXPECT_THROW(figure_of(of_one, "surface"), std::out_of_range) << "a ridge takes two";
}

}  // namespace
}  // namespace credence::internal
