#include "reports/document/stability/stability_report.h"

#include <gmock/gmock.h>

#include <gtest/gtest.h>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "montecarlo/scenario/world_schema.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// x' = F x + w, z = x + v, of unit noise, from P0 = 1.
StabilityAnalysis scalar(double F, double Q = 1.0) {
  LinearModel model;
  model.F = Matrix::Constant(1, 1, F);
  model.G = model.H = model.R = model.P0 = Matrix::Identity(1, 1);
  model.Q = Matrix::Constant(1, 1, Q);
  model.layout = {.vehicle = 1, .landmark = 1, .landmarks = 0};
  return analyse_stability(model, {}, 50, 256, {"x"});
}

Document stability_shown(const StabilityAnalysis& analysis, Index period = 1) {
  return stability_document(default_scenario("monobot"), analysis, period);
}

nlohmann::json stability_data(const StabilityAnalysis& analysis) {
  return nlohmann::json::parse(stability_shown(analysis).json());
}

std::string stability_row(const Document& document, const std::string& question) {
  for (const auto& row : table_of(document, "Stability").rows) {
    if (row[0].text.find(question) != std::string::npos) return row[1].text + ": " + row[2].text;
  }
  return "no row";
}

// The prior variance of a level is the root of p² = p + 1: the golden ratio, and its gain the inverse of
// that.
TEST(StabilityReport, OfALevelTheGoldenRatio) {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  const StabilityAnalysis analysis = scalar(1.0);
  const auto j = stability_data(analysis);
  EXPECT_NEAR(j["riccati"]["trace"].get<double>(), golden, 1e-9);
  EXPECT_NEAR(j["riccati"]["gain"][0][0].get<double>(), 1.0 / golden, 1e-9);
  EXPECT_EQ(j["riccati"]["bounded"], true);
  EXPECT_NEAR(j["spectral_radius"].get<double>(), 1.0 - 1.0 / golden, 1e-9);
  EXPECT_EQ(j["predicted_bounded"], true);
  EXPECT_EQ(j["initial_covariance"]["depends"], false);
  EXPECT_EQ(j["long_horizon"]["verdict"], "bounded");
  EXPECT_EQ(j["noise_condition"]["bounded"], true);
  EXPECT_GE(j["noise_condition"]["trace_bound"].get<double>(), golden - 1.0);
  const Document document = stability_shown(analysis);
  EXPECT_EQ(
      document.answer.text,
      "P stays bounded, measured over 256 steps and as the exact condition says; its limit does not depend "
      "on P0");
  EXPECT_EQ(document.answer.tone, CellTone::good);
  EXPECT_THAT(stability_row(document, "error of a single run"),
              HasSubstr("forgotten: spectral radius 0.38196601"));
  EXPECT_THAT(stability_row(document, "Riccati"), HasSubstr("trace of the prior 1.61803;"));
  EXPECT_THAT(stability_shown(analysis, 12).answer.text,
              EndsWith("; a step is here a whole period of 12, with P at its end"));
}

TEST(StabilityReport, TheLongHorizonIsToldAtPowersOfTwo) {
  const StabilityAnalysis analysis = scalar(1.0);
  const auto j = stability_data(analysis)["long_horizon"];
  EXPECT_EQ(j["steps"], 256);
  ASSERT_EQ(j["step"].size(), 9U);
  double prior = 2.0, posterior = 0.0;  // of step 1: P0 + Q
  std::size_t told = 0;
  for (int k = 1; k <= 256; ++k) {
    posterior = prior / (prior + 1.0);
    if (j["step"][told] == k) {
      EXPECT_NEAR(j["trace_prior"][told].get<double>(), prior, 1e-12) << k;
      EXPECT_NEAR(j["trace"][told].get<double>(), posterior, 1e-12) << k;
      ++told;
    }
    prior = posterior + 1.0;
  }
  EXPECT_EQ(told, 9U);
}

TEST(StabilityReport, WhatIsNotTheIdentityHasNoConditionAndSaysWhy) {
  const auto j = stability_data(scalar(0.9));
  EXPECT_TRUE(j["noise_condition"].is_null());
  EXPECT_EQ(j["noise_condition_null_reason"], "F is not the identity");
  EXPECT_EQ(stability_row(stability_shown(scalar(0.9)), "eq. (22)"), "no row")
      << "the paper's is one on static maps";
  EXPECT_NE(stability_row(stability_shown(scalar(1.0)), "eq. (22)"), "no row");
}

/// A level beside one that nothing measures and noise moves.
StabilityAnalysis half_seen() {
  LinearModel model;
  model.F = model.G = model.Q = model.P0 = Matrix::Identity(2, 2);
  model.Q(1, 1) = 0.25;
  model.H = Matrix::Identity(2, 2).topRows(1);
  model.R = Matrix::Identity(1, 1);
  model.layout = {.vehicle = 2, .landmark = 1, .landmarks = 0};
  return analyse_stability(model, {}, 50, 256, {"seen", "unseen"});
}

TEST(StabilityReport, WhatGrowsIsNamedWithItsRate) {
  const StabilityAnalysis analysis = half_seen();
  const auto j = stability_data(analysis);
  EXPECT_EQ(j["predicted_bounded"], false);
  EXPECT_EQ(j["riccati"]["bounded"], false);
  EXPECT_EQ(j["noise_condition"]["bounded"], false);
  EXPECT_TRUE(j["noise_condition"]["trace_bound"].is_null());
  EXPECT_EQ(j["noise_condition"]["null_reason"], "P grows");
  EXPECT_NEAR(j["noise_condition"]["rate"].get<double>(), 0.25, 1e-12) << "its Q";
  EXPECT_NEAR(j["noise_condition"]["growth_per_step"].get<double>(), 0.25, 1e-12);
  EXPECT_NEAR(std::abs(j["noise_condition"]["direction"][1].get<double>()), 1.0, 1e-12);
  EXPECT_NEAR(j["long_horizon"]["growth_per_step"].get<double>(), 0.25, 1e-6);
  EXPECT_TRUE(j["initial_covariance"]["depends"].is_null());
  EXPECT_EQ(j["initial_covariance"]["null_reason"], "no limit to compare");
  EXPECT_EQ(j["rank"]["observability"], 1);
  EXPECT_EQ(j["rank"]["controllability"], 2);
  const Document document = stability_shown(analysis);
  EXPECT_EQ(document.answer.text,
            "P grows without bound, measured over 256 steps and as the exact condition says");
  EXPECT_EQ(document.answer.tone, CellTone::alarm);
  EXPECT_EQ(stability_row(document, "exact condition"),
            "unbounded: noise, or a direction that stays, drives an unobservable one");
  EXPECT_THAT(stability_row(document, "bound or growth"),
              HasSubstr("grows by at least 0.2500 per step; tr P by 0.2500 per step in the limit"));
  EXPECT_THAT(stability_row(document, "depend on P0"), testing::StartsWith("no limit"));
  EXPECT_THAT(table_of(document, "Ranks").rows.at(1).at(4).text, HasSubstr("unseen"));
}

// A constant ΔP is in the condition as in the recursion: which then still grows after so many steps, and has
// a bound, or grows too slowly to be seen.
TEST(StabilityReport, OfAConstantInflationTheConditionDecidesNotTheStepsMeasured) {
  StabilityAnalysis analysis = scalar(1.0);
  analysis.inflation_varies = false;
  analysis.long_horizon.growth.verdict = LongRun::growing;
  EXPECT_EQ(stability_shown(analysis).answer.text,
            "P stays bounded, as the exact condition says, but is still growing after 256 steps");
  EXPECT_EQ(stability_shown(analysis).answer.tone, CellTone::good);
  analysis.predicted_bounded = analysis.riccati.stays_bounded = false;
  analysis.riccati.kind = RiccatiKind::unbounded;
  EXPECT_THAT(stability_shown(analysis).answer.text,
              StartsWith("P grows without bound, measured over 256 steps and"));
  analysis.long_horizon.growth.verdict = LongRun::bounded;
  EXPECT_THAT(stability_shown(analysis).answer.text, HasSubstr("so slowly that 256 steps do not show it"));
  EXPECT_EQ(stability_shown(analysis).answer.tone, CellTone::alarm);
}

// Nothing excites the state that would explode unseen: P is constant, and the condition is one on every P0.
TEST(StabilityReport, WhatThisStartLeavesOutDoesNotGrow) {
  LinearModel model;
  model.F = Vector{{1.1, 0.5}}.asDiagonal();
  model.G = Matrix{{0.0}, {1.0}};
  model.H = Matrix{{0.0, 1.0}};
  model.Q = model.R = Matrix::Identity(1, 1);
  model.P0 = Vector{{0.0, 1.0}}.asDiagonal();
  model.layout = {.vehicle = 2, .landmark = 1, .landmarks = 0};
  StabilityAnalysis analysis = analyse_stability(model, {}, 50, 256, {"x", "y"});
  EXPECT_FALSE(analysis.predicted_bounded);
  const ReportAnswer answer = stability_shown(analysis).answer;
  EXPECT_EQ(answer.text,
            "P stays bounded from this P0, measured over 256 steps; not from every P0, as the exact "
            "condition says");
  EXPECT_EQ(answer.tone, CellTone::caution);
  analysis.long_horizon.growth.verdict = LongRun::growing;
  EXPECT_THAT(stability_shown(analysis).answer.text,
              HasSubstr("from this P0, but is still growing after 256 steps; not from every P0"));
  model.P0(0, 0) = 1e-6;
  EXPECT_THAT(stability_shown(analyse_stability(model, {}, 50, 256, {"x", "y"})).answer.text,
              StartsWith("P grows without bound"));
}

// Without noise nothing drives P, but what is learnt is kept for ever.
TEST(StabilityReport, OnTheCircleAPartStays) {
  const Document document = stability_shown(scalar(1.0, 0.0));
  EXPECT_THAT(document.answer.text, testing::StartsWith("P stays bounded"));
  EXPECT_THAT(table_of(document, "Ranks").rows.at(0).at(1).text, "0");
}

TEST(StabilityReport, TheKindOfTheSolutionIsExplained) {
  LinearModel turn;
  turn.F = Matrix{{0.8, -0.6}, {0.6, 0.8}};
  turn.G = turn.P0 = Matrix::Identity(2, 2);
  turn.P0(1, 1) = 2.0;
  turn.Q = Matrix::Zero(2, 2);
  turn.H = Matrix::Zero(1, 2);
  turn.R = Matrix::Identity(1, 1);
  turn.layout = {.vehicle = 2, .landmark = 1, .landmarks = 0};
  StabilityAnalysis analysis = analyse_stability(turn, {}, 50, 256, {"x", "y"});
  EXPECT_EQ(stability_data(analysis)["riccati"]["kind"], "oscillating");
  EXPECT_EQ(stability_data(analysis)["riccati"]["bounded"], true) << "as predicted_bounded";
  const auto notes = [](const StabilityAnalysis& a) {
    return table_of(stability_shown(a), "Stability").notes;
  };
  EXPECT_THAT(notes(analysis).at(1),
              testing::StartsWith("Solution oscillating: P stays bounded and has no limit"));
  turn.F.setIdentity();
  EXPECT_THAT(notes(analyse_stability(turn, {}, 50, 256, {"x", "y"})).at(1),
              testing::StartsWith("Solution psd depending on P0: P tends to a limit that is another one"));
  EXPECT_THAT(notes(scalar(1.0)).at(1), testing::StartsWith("Solution stabilising"));
  EXPECT_THAT(notes(half_seen()).at(1), testing::StartsWith("Solution none"));
  analysis.riccati.kind = RiccatiKind::undecided;
  analysis.riccati.stays_bounded = false;
  EXPECT_TRUE(stability_data(analysis)["riccati"]["bounded"].is_null()) << "nobody knows";
}

TEST(StabilityReport, AFilterThatBreaksDownIsSaidAndNoNumberIsInvented) {
  LinearModel blind;
  blind.F = Vector{{1.0, 3.0}}.asDiagonal();
  blind.G = blind.P0 = blind.Q = Matrix::Identity(2, 2);
  blind.H = Matrix{{1.0, 0.0}};
  blind.R = Matrix::Identity(1, 1);
  blind.layout = {.vehicle = 2, .landmark = 1, .landmarks = 0};
  StabilityAnalysis analysis = analyse_stability(blind, {}, 400, 400, {"x", "y"});
  const Document document = stability_shown(analysis);
  EXPECT_EQ(document.answer.text,
            "The filter breaks down: P leaves the range of double at step 323; P grows without bound: an "
            "unobservable direction is unstable");
  EXPECT_EQ(document.answer.tone, CellTone::alarm);
  const auto j = stability_data(analysis);
  EXPECT_EQ(j["long_horizon"]["verdict"], "failed");
  EXPECT_EQ(j["long_horizon"]["steps"], j["steps"]);
  EXPECT_THAT(j["long_horizon"]["failure"].get<std::string>(),
              StartsWith("P leaves the range of double at step 323"));
  EXPECT_EQ(j["unobservable"], nlohmann::json::array({"1.00 y"}));
  EXPECT_THAT(j["notes"][0].get<std::string>(), EndsWith("those of step 322, the last that succeeds."));
  EXPECT_THAT(stability_row(document, "P of the filter itself, 322 steps"), HasSubstr("prior "));

  // From the first step on.
  analysis = scalar(1e200, 1e300);
  const auto none = stability_data(analysis);
  EXPECT_EQ(none["steps"], 0);
  EXPECT_EQ(none["gain"], nlohmann::json::array({nlohmann::json::array({nullptr})}));
  EXPECT_TRUE(none["spectral_radius"].is_null());
  EXPECT_TRUE(none["long_horizon"]["growth_per_step"].is_null());
  EXPECT_THAT(none["notes"][0].get<std::string>(), EndsWith("No step succeeds: K is not known, and Q_t is "
                                                            "without a ΔP."));
}

TEST(StabilityReport, WhatIsNotKnownIsLeftOutOrSaidToBeUnknown) {
  const auto without_nan = [](const StabilityAnalysis& analysis) {
    const Document document = stability_shown(analysis);
    for (const char* table : {"Stability", "Ranks"}) {
      for (const auto& row : table_of(document, table).rows)
        for (const TableCell& cell : row) EXPECT_THAT(cell.text, Not(HasSubstr("nan"))) << row[0].text;
    }
    return document;
  };
  const Document none = without_nan(scalar(1e200, 1e300));  // no step succeeds
  EXPECT_EQ(stability_row(none, "error of a single run"),
            "not known: eigenvalues not known, as no step succeeds");
  EXPECT_EQ(stability_row(none, "Riccati"),
            "undecided: solution: undecided; the first prior leaves the range of double");
  EXPECT_EQ(stability_row(none, "largest gains"), "no limit: not known");
  EXPECT_THAT(stability_row(stability_shown(half_seen()), "largest gains"),
              testing::ContainsRegex("^no limit: after [0-9.e]+ steps they are "));

  StabilityAnalysis analysis = scalar(1.0);  // as of an R that leaves the range of double when inverted
  analysis.riccati.kind = RiccatiKind::undecided;
  analysis.riccati.reason = "the growth exponent is 0";
  analysis.riccati.steps = 1.0;
  analysis.riccati.growth_exponent = 0.0;
  analysis.riccati.P(0, 0) = analysis.riccati.K(0, 0) = analysis.riccati.residual = std::nan("");
  EXPECT_THAT(stability_row(without_nan(analysis), "Riccati"),
              EndsWith("solution: undecided; growth exponent 0.00; the growth exponent is 0"));
  analysis.closed_loop_eigenvalues.resize(0);
  analysis.spectral_radius = std::nan("");
  EXPECT_EQ(stability_row(without_nan(analysis), "error of a single run"),
            "not known: eigenvalues not computed: the iteration did not converge");
}

TEST(StabilityReport, UnitsAreMetresOnlyWhereAllStatesAre) {
  StabilityAnalysis analysis = half_seen();
  EXPECT_FALSE(analysis.in_metres);
  EXPECT_THAT(stability_row(stability_shown(analysis), "bound or growth"), Not(HasSubstr("m²")));
  analysis.in_metres = true;
  EXPECT_THAT(stability_row(stability_shown(analysis), "bound or growth"), HasSubstr("0.2500 m² per step"));
}

TEST(StabilityReport, TheFigureHasTheCovarianceTheCircleAndTheEigenvalues) {
  const StabilityAnalysis analysis = scalar(1.0);
  const Figure figure = figure_of(stability_shown(analysis), "stability");
  EXPECT_NO_THROW(validate(figure));
  const Panel &traces = figure.panels.at(0), &plane = figure.panels.at(1);
  EXPECT_EQ(traces.series.at(0).y.at(0), 2.0);
  EXPECT_NEAR(traces.series.at(1).y.at(0), 2.0 / 3.0, 1e-15);
  EXPECT_EQ(traces.series.at(2).x.at(0), 50.0);
  for (std::size_t i = 0; i < plane.series.at(0).x.size(); ++i) {
    EXPECT_NEAR(std::hypot(plane.series[0].x[i], plane.series[0].y[i]), 1.0, 1e-12);
  }
  EXPECT_NEAR(plane.series.at(1).x.at(0), 0.5 * (3.0 - std::sqrt(5.0)), 1e-9);
  EXPECT_EQ(figure_of(stability_shown(half_seen()), "stability").panels[1].series.size(), 2U)
      << "no limit, none of its";
}

TEST(StabilityJson, ARankHasItsGapOrTheReasonWhyNot) {
  EXPECT_EQ(rank_json(decide_rank(Vector{{4.0, 2.0, 1e-12}})).dump(),
            R"({"rank":2,"gap":2000000000000.0,"singular_values":[4.0,2.0,1e-12]})");
  const Json all = as_read(rank_json(decide_rank(Vector{{4.0, 2.0}})));
  EXPECT_TRUE(all["gap"].is_null());
  EXPECT_TRUE(all["gap_null_reason"].is_string());
}

TEST(StabilityJson, EigenvaluesArePairs) {
  Eigen::VectorXcd values(2);
  values << std::complex<double>(0.5, -0.25), std::complex<double>(1.0, 0.0);
  EXPECT_EQ(eigenvalues_json(values).dump(), "[[0.5,-0.25],[1.0,0.0]]");
  EXPECT_EQ(eigenvalues_json(Eigen::VectorXcd()).dump(), "[]");
}

}  // namespace
}  // namespace credence::internal
