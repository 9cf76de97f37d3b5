#include "reports/document/study/trace_report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/number_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

Document trace_of(std::int64_t steps) {
  Scenario scenario = default_scenario("monobot");
  scenario.study.steps = steps;
  return trace_document(scenario, make_experiment(scenario)->trace(4));
}

std::vector<std::string> steps_shown(const Document& document) {
  std::vector<std::string> steps;
  for (const auto& row : std::get<ReportTable>(document.brief.front()).rows) steps.push_back(row[0].text);
  return steps;
}

TEST(TraceDocument, ShowsEveryStepOfAShortRun) {
  EXPECT_EQ(steps_shown(trace_of(3)), (std::vector<std::string>{"0", "1", "2", "3"}));
}

TEST(TraceDocument, OfALongRunShowsSomeTwentyStepsAndTheLast) {
  for (const std::int64_t steps : {20, 21, 57, 1000}) {
    const std::vector<std::string> shown = steps_shown(trace_of(steps));
    EXPECT_EQ(shown.front(), "0");
    EXPECT_EQ(shown.back(), std::to_string(steps));
    EXPECT_LE(shown.size(), 22U);
  }
}

TEST(TraceDocument, WithoutDegreesOfFreedomThereIsNoNumber) {
  const Document document = trace_of(3);
  const auto& rows = std::get<ReportTable>(document.brief.front()).rows;
  for (const std::size_t value : {2U, 4U}) {
    EXPECT_EQ(rows[0][value].text, "–");
    EXPECT_EQ(rows[0][value + 1].text, "0");
    EXPECT_NE(rows[1][value].text, "–");
  }
}

TEST(TraceDocument, AnglesAreInDegrees) {
  Scenario scenario = default_scenario("planar");
  scenario.study.steps = 3;
  const RunTrace trace = make_experiment(scenario)->trace(0);
  const Document document = trace_document(scenario, trace);
  const auto& table = std::get<ReportTable>(document.brief.front());
  EXPECT_EQ(table.columns[1].title, "error of x (m), y (m), θ (°) ± 2σ");
  const TraceStep& last = trace.steps.back();
  const double degrees = 180.0 / std::numbers::pi;
  const std::string shown = fmt::format(", {} ± {}", number_text(degrees * last.error[2], 3),
                                        number_text(degrees * 2.0 * std::sqrt(last.P(2, 2)), 3));
  EXPECT_TRUE(table.rows.back()[1].text.ends_with(shown)) << table.rows.back()[1].text << shown;
}

TEST(TraceDocument, StatesHaveTheirUnits) {
  Scenario scenario = default_scenario("pendulum");
  scenario.study.steps = 3;
  const RunTrace trace = make_experiment(scenario)->trace(0);
  const Document document = trace_document(scenario, trace);
  EXPECT_EQ(std::get<ReportTable>(document.brief.front()).columns[1].title,
            fmt::format("error of {} (°), {} (°/s) ± 2σ", trace.layout.states[0], trace.layout.states[1]));
}

TEST(TraceDocument, AsDataHasAllOfThem) {
  const auto json = nlohmann::json::parse(trace_of(57).json());
  EXPECT_EQ(json["run"], 4);
  EXPECT_EQ(json["steps"].size(), 58U);
}

// Landmarks come into the state out of the order of their numbers: each step names its own.
TEST(TraceDocument, NamesTheLandmarksOfEachStepInTheOrderOfItsState) {
  Scenario scenario = default_scenario("planar");
  scenario.study.steps = 200;
  const RunTrace trace = make_experiment(scenario)->trace(0);
  const auto json = nlohmann::json::parse(trace_document(scenario, trace).json());
  for (const auto& step : json["steps"]) {
    ASSERT_EQ(step["estimate"].size(), 3 + 2 * step["landmarks"].size());
    for (std::size_t i = 0; i < step["landmarks"].size(); ++i) {
      const auto& place = json["landmark_positions"][step["landmarks"][i].get<std::size_t>()];
      EXPECT_EQ(step["truth"][3 + 2 * i], place[0]);
      EXPECT_EQ(step["truth"][4 + 2 * i], place[1]);
    }
  }
}

}  // namespace
}  // namespace credence::internal
