#include "reports/document/stability/planar_stability_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/nan.h"
#include "montecarlo/scenario/world_schema.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

Scenario planar_map(InflationSolution solution, FilterInflation inflation = FilterInflation::map) {
  Scenario scenario = default_scenario("planar");
  scenario.filter.inflation = inflation;
  scenario.filter.solution = solution;
  return scenario;
}

PlanarFollowed followed_of(Linearisation at, InflationSolution solution, LongRun verdict,
                           std::vector<double> traces) {
  PlanarFollowed f;
  f.at = at;
  f.solution = solution;
  f.growth = {.verdict = verdict, .per_sample = 0.25, .exponent = verdict == LongRun::growing ? 1.0 : 0.0};
  f.traces = std::move(traces);
  f.inflation_rank = 9;
  f.spectral_radius = 0.75;
  f.pose_nees = at == Linearisation::estimate ? 1.25 : kNaN;
  f.initial_effect = at == Linearisation::truth ? 40.0 : kNaN;
  f.closed_loop_eigenvalues.resize(2);
  f.closed_loop_eigenvalues << std::complex<double>(0.75, 0.0), std::complex<double>(0.25, -0.5);
  return f;
}

/// The bound of the noise accumulated over a loop.
ExactBoundedness predicted(BoundednessReason reason, Index rank) {
  ExactBoundedness exact;
  exact.reason = reason;
  exact.noise.rank = rank;
  exact.noise.singular_values = Vector{{1.0, 0.5}};
  exact.noise.gap = 1e6;
  return exact;
}

/// Twelve loops of a map of six landmarks: the pairwise sum grows, the exact solution stays.
PlanarStability planar_case() {
  PlanarStability a;
  a.state_dim = 15;
  a.loops = 12;
  a.steps_per_loop = 63;
  a.process_rank = 3;
  a.truth.observability.decision = {.rank = 12, .singular_values = Vector{{1.0, 0.5}}, .gap = 1e8};
  a.truth.unobservable = {"vehicle.x", "landmark 2"};
  a.estimate.observability.decision = {.rank = 13, .singular_values = Vector{{1.0}}, .gap = HUGE_VAL};
  std::vector<double> growing, flat(12, 4.0);
  for (int k = 1; k <= 12; ++k) growing.push_back(2.0 * k);
  for (const Linearisation at : {Linearisation::truth, Linearisation::estimate}) {
    a.followed.push_back(followed_of(at, InflationSolution::pairwise, LongRun::growing, growing));
    a.followed.back().exact = predicted(BoundednessReason::unpaired, 14);
    a.followed.push_back(followed_of(at, InflationSolution::min_trace, LongRun::bounded, flat));
    a.followed.back().exact = predicted(BoundednessReason::paired, 12);
    a.followed.back().not_converged = 7;
    a.followed.push_back(followed_of(at, InflationSolution::sequential, LongRun::bounded, flat));
  }
  return a;
}

std::vector<std::string> words_of_row(const std::vector<TableCell>& row) {
  std::vector<std::string> texts;
  for (const TableCell& cell : row) texts.push_back(cell.text);
  return texts;
}

TEST(PlanarStabilityReport, AnswersOfTheOwnSolutionAtTheTruthAndInTheEkf) {
  const PlanarStability a = planar_case();
  const ReportAnswer grows = planar_stability_document(planar_map(InflationSolution::pairwise), a).answer;
  EXPECT_EQ(grows.tone, CellTone::alarm);
  EXPECT_EQ(
      grows.text,
      "Over 12 loops with Jacobians at the truth P is growing with the solution pairwise (min-trace bounded, "
      "sequential bounded); in a noisy run of the EKF it is growing, with a NEES of the pose of 1.25 times "
      "its expected value");
  const ReportAnswer stays = planar_stability_document(planar_map(InflationSolution::min_trace), a).answer;
  EXPECT_EQ(stays.tone, CellTone::good);
  EXPECT_THAT(stays.text,
              StartsWith("Over 12 loops with Jacobians at the truth P is bounded with the solution "
                         "min-trace (pairwise growing, sequential bounded);"));
  PlanarStability alone = planar_case();
  std::erase_if(alone.followed,
                [](const PlanarFollowed& f) { return f.solution != InflationSolution::pairwise; });
  EXPECT_THAT(planar_stability_document(planar_map(InflationSolution::pairwise), alone).answer.text,
              StartsWith("Over 12 loops with Jacobians at the truth P is growing;"));
}

// A bounded P of a filter that is wrong is no good news.
TEST(PlanarStabilityReport, AnOptimisticEkfIsAnAlarmWhateverPDoes) {
  PlanarStability a = planar_case();
  a.followed[4].pose_nees = 2.25;
  const ReportAnswer answer = planar_stability_document(planar_map(InflationSolution::min_trace), a).answer;
  EXPECT_EQ(answer.tone, CellTone::alarm);
  EXPECT_THAT(answer.text, testing::EndsWith("2.25 times its expected value: it is optimistic"));
}

// Nor is one that ends before its time.
TEST(PlanarStabilityReport, AnEkfThatFailsIsAnAlarmWhateverPDoesAtTheTruth) {
  PlanarStability a = planar_case();
  a.followed[4].failed_at = 6;
  a.followed[4].pose_nees = kNaN;
  const ReportAnswer answer = planar_stability_document(planar_map(InflationSolution::min_trace), a).answer;
  EXPECT_EQ(answer.tone, CellTone::alarm);
}

TEST(PlanarStabilityReport, EveryFilterHasARow) {
  const ReportTable table = table_of(
      planar_stability_document(planar_map(InflationSolution::pairwise), planar_case()), "Covariance over");
  EXPECT_EQ(table.title, "Covariance over 12 loops of 63 steps");
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_THAT(words_of_row(table.rows[0]),
              ElementsAre(to_string(InflationSolution::pairwise), "the truth", "growing", "2.000", "12.00",
                          "24.00", "1.00", "0.250", "unbounded", "9", "0", "× 40.0", "–"));
  EXPECT_THAT(words_of_row(table.rows[4]),
              ElementsAre(to_string(InflationSolution::min_trace), "the estimate (EKF)", "bounded", "4.000",
                          "4.000", "4.000", "0.00", "0.250", "bounded", "9", "7", "–", "1.25"));
  EXPECT_EQ(table.rows[0][2].tone, CellTone::alarm);
  EXPECT_EQ(table.rows[1][2].tone, CellTone::good);
  EXPECT_EQ(table.rows[2][0].text, std::string(to_string(InflationSolution::sequential)) + ", O(N)");
  EXPECT_EQ(table.rows[2][8].text, "–") << "inflates within the update";
  EXPECT_EQ(table.rows[2][9].text, "–");
  PlanarStability few = planar_case();
  few.followed[0].traces.resize(4);
  EXPECT_EQ(table_of(planar_stability_document(planar_map(InflationSolution::pairwise), few), "Covariance")
                .rows[0][4]
                .text,
            "–")
      << "there is no tenth loop";
}

TEST(PlanarStabilityReport, WithoutInflationNoSolutionIsNamed) {
  const ReportTable table =
      table_of(planar_stability_document(planar_map(InflationSolution::pairwise, FilterInflation::none),
                                         planar_case()),
               "Covariance over");
  EXPECT_EQ(table.rows[0][0].text, "no inflation");
}

TEST(PlanarStabilityReport, RanksAreToldAtTheTruthAndAtTheEstimate) {
  const ReportTable table = table_of(
      planar_stability_document(planar_map(InflationSolution::pairwise), planar_case()), "Observability");
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_THAT(words_of_row(table.rows[0]),
              ElementsAre("the truth", "12", "15", "1.00e8", "vehicle.x, landmark 2"));
  EXPECT_THAT(words_of_row(table.rows[1]), ElementsAre("the estimate (EKF)", "13", "15", "∞", "nothing"));
}

TEST(PlanarStabilityReport, TheFigureHasAPanelForEachLinearisation) {
  const Document document = planar_stability_document(planar_map(InflationSolution::pairwise), planar_case());
  const Figure figure = figure_of(document, "planar-growth");
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_EQ(figure.panels[1].title.text, "Jacobians at the estimate (EKF)");
  ASSERT_EQ(figure.panels[0].series.size(), 3U);
  EXPECT_EQ(figure.panels[0].series[0].x.back(), 12.0);
  EXPECT_EQ(figure.panels[0].series[0].y.back(), 24.0);
  PlanarStability nothing = planar_case();
  for (PlanarFollowed& f : nothing.followed) f.traces.clear();
  EXPECT_THROW(
      figure_of(planar_stability_document(planar_map(InflationSolution::pairwise), nothing), "planar-growth"),
      std::out_of_range)
      << "no filter came to the end of a loop";
}

TEST(PlanarStabilityJson, HasTheNumbersOfTheOwnSolution) {
  const PlanarStability a = planar_case();
  const auto data = [&](InflationSolution solution) {
    return nlohmann::ordered_json::parse(planar_stability_json(planar_map(solution), a));
  };
  const auto grows = data(InflationSolution::pairwise), stays = data(InflationSolution::min_trace);
  std::vector<std::string> keys;
  for (const auto& [key, value] : grows.items()) keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("schema", "scenario", "state_dim", "loops", "steps_per_loop", "rank",
                                "rank_details", "unobservable", "closed_loop_eigenvalues", "spectral_radius",
                                "riccati", "predicted_bounded", "paper_condition_holds", "filters"));
  EXPECT_EQ(grows["rank"].dump(), R"({"controllability":3,"observability":12,"observability_at_estimate":13,)"
                                  R"("inflation":9,"noise_total":14})");
  EXPECT_EQ(grows["riccati"]["bounded"], false);
  EXPECT_EQ(grows["riccati"]["trace"], 24.0);
  EXPECT_EQ(grows["riccati"]["growth_exponent"], 1.0);
  EXPECT_EQ(grows["predicted_bounded"], false);
  EXPECT_EQ(grows["paper_condition_holds"], true) << "9 ≤ 12, although P grows";
  EXPECT_EQ(grows["closed_loop_eigenvalues"].dump(), "[[0.75,0.0],[0.25,-0.5]]");
  EXPECT_EQ(grows["scenario"]["filter"]["solution"], to_string(InflationSolution::pairwise));
  EXPECT_EQ(stays["riccati"]["bounded"], true);
  EXPECT_EQ(stays["predicted_bounded"], true);
  EXPECT_EQ(stays["rank"]["noise_total"], 12);
  EXPECT_TRUE(data(InflationSolution::sequential)["predicted_bounded"].is_null());
  EXPECT_TRUE(data(InflationSolution::sequential)["rank"]["noise_total"].is_null());
  EXPECT_TRUE(data(InflationSolution::sequential)["rank"]["inflation"].is_null());
  EXPECT_TRUE(data(InflationSolution::sequential)["paper_condition_holds"].is_null());
}

TEST(PlanarStabilityJson, EveryFilterHasWhatIsKnownOfIt) {
  const auto filters = nlohmann::ordered_json::parse(
      planar_stability_json(planar_map(InflationSolution::pairwise), planar_case()))["filters"];
  ASSERT_EQ(filters.size(), 6U);
  EXPECT_EQ(filters[0]["jacobians_at"], "truth");
  EXPECT_EQ(filters[0]["initial_covariance_effect"], 40.0);
  EXPECT_FALSE(filters[0].contains("pose_nees_ratio")) << "without noise there is none";
  EXPECT_EQ(filters[0]["trace"].size(), 12U);
  EXPECT_EQ(filters[0]["prediction_reason"], to_string(BoundednessReason::unpaired));
  EXPECT_EQ(filters[0]["accumulated_noise_singular_values"].dump(), "[1.0,0.5]");
  EXPECT_EQ(filters[4]["jacobians_at"], "estimate");
  EXPECT_EQ(filters[4]["pose_nees_ratio"], 1.25);
  EXPECT_FALSE(filters[4].contains("initial_covariance_effect"));
  EXPECT_EQ(filters[4]["steps_above_duality_gap"], 7);
  EXPECT_TRUE(filters[5]["predicted_bounded"].is_null());
  EXPECT_EQ(filters[5]["prediction_reason"], "a sequential rule inflates within the update");
}

TEST(PlanarStabilityReport, ItsJsonIsTheSameAsThePages) {
  const Scenario scenario = planar_map(InflationSolution::min_trace);
  EXPECT_EQ(planar_stability_document(scenario, planar_case()).json(),
            planar_stability_json(scenario, planar_case()));
}

TEST(PlanarStabilityReport, TracesHaveTheUnitOfTheirFigure) {
  const Document document =
      planar_stability_document(planar_map(InflationSolution::min_trace), planar_case());
  EXPECT_THAT(
      table_of(document, "Covariance over").notes,
      testing::Contains(HasSubstr("mean of tr P over the loop, in m² + rad², as is the growth a loop.")));
}

TEST(PlanarStabilityReport, OfAFilterThatFailsIsSaidWhenAndNoNumberIsInvented) {
  PlanarStability a = planar_case();
  for (PlanarFollowed& f : a.followed) {
    if (f.solution != InflationSolution::pairwise) continue;
    f.growth = {};
    f.failed_at = 167;
    f.traces.clear();
    f.pose_nees = f.initial_effect = kNaN;
    f.exact.reset();
  }
  const Scenario scenario = planar_map(InflationSolution::pairwise);
  const Document document = planar_stability_document(scenario, a);
  EXPECT_THAT(document.answer.text, HasSubstr("P is lost at step 167 (the filter fails there)"));
  EXPECT_THAT(document.answer.text, Not(HasSubstr("nan")));
  for (const auto& row : table_of(document, "Covariance over").rows) {
    for (const TableCell& cell : row) EXPECT_NE(cell.text, "nan");
  }
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["filters"][0]["verdict"], "failed");
  EXPECT_EQ(j["filters"][0]["failed_at_step"], 167);
  EXPECT_TRUE(j["filters"][0]["growth_exponent"].is_null());
  EXPECT_EQ(j["filters"][0]["prediction_reason"], "the filter fails before the last loop has ended");
}

}  // namespace
}  // namespace credence::internal
