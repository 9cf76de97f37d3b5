#include "reports/document/checks/timing_report.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/nan.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

MeasuredTime about(double seconds) {
  return {.repetitions = {}, .median = seconds, .lower = 0.9 * seconds, .upper = 1.2 * seconds};
}

/// The full filter takes N² ns a step, the one of map blocks 20 N ns, which is less from N = 20 on.
TimingResult quadratic_and_linear() {
  TimingResult result;
  result.machine = {
      .processor = "A processor", .processors = 4, .instruction_set = "AVX2", .compiler = "c", .load = 0.1};
  result.complete = true;
  for (const Index n : {10, 100, 1000, 10'000}) {
    const auto N = static_cast<double>(n);
    for (const Index observed : {1, 10}) {
      if (n < 10'000) {
        result.filters.push_back({TimedFilter::full, n, observed, about(1e-9 * N * N), 8e-3 * 1e3 * N * N});
      }
      result.filters.push_back({TimedFilter::map, n, observed, about(20e-9 * N), std::nullopt});
    }
  }
  for (const TimedFilter filter : {TimedFilter::full, TimedFilter::map}) {
    const double exponent = filter == TimedFilter::full ? 2.0 : 1.0;
    result.growth.push_back(
        {filter, 1, 10, 3, {.exponent = exponent, .lower = exponent - 0.1, .upper = exponent + 0.1}});
  }
  result.crossovers = {{1, 20.0, TimedFilter::full}, {10, std::nullopt, TimedFilter::map}};
  result.monte_carlo = {.step = about(1e-7), .normal = about(4e-9), .reference_step = about(6e-7)};
  result.scaling = {{1, about(1e-3)}, {4, about(0.3e-3)}};
  return result;
}

TEST(TimingReport, TheAnswerHasTheLawsAndWhereTheLinearFilterWins) {
  const ReportAnswer answer = timing_document(quadratic_and_linear()).answer;
  EXPECT_EQ(
      answer.text,
      "A step of the O(N), map blocks filter takes time that grows like N^1.00, of the full filter takes "
      "time that grows like N^2.00; the O(N) filter is the faster one from 20 landmarks on (1 observed)");
  EXPECT_EQ(answer.tone, CellTone::good);
}

TEST(TimingReport, ABusyMachineIsSaidAndAnUnknownLoadIsNot) {
  TimingResult result = quadratic_and_linear();
  result.machine.load = 3.5;
  EXPECT_THAT(timing_document(result).answer.text, HasSubstr("The machine was busy (load 3.5)"));
  EXPECT_EQ(timing_document(result).answer.tone, CellTone::caution);
  result.machine.load = kNaN;
  const Document document = timing_document(result);
  EXPECT_THAT(document.answer.text, Not(HasSubstr("busy")));
  EXPECT_TRUE(nlohmann::json::parse(document.json())["machine"]["load"].is_null());
}

TEST(TimingReport, TableAndDataHaveEverySize) {
  const TimingResult result = quadratic_and_linear();
  const Document document = timing_document(result);
  const ReportTable table = table_of(document, "One step");
  const auto j = nlohmann::json::parse(document.json());
  ASSERT_EQ(table.rows.size(), 14U);
  ASSERT_EQ(j["rows"].size(), 14U);
  // 100 landmarks, one observed: 1e4 ns.
  const auto& full = j["rows"][4];
  EXPECT_EQ(full["filter"], "full");
  EXPECT_EQ(full["landmarks"], 100);
  EXPECT_EQ(full["observed"], 1);
  EXPECT_DOUBLE_EQ(full["seconds_per_step"].get<double>(), 1e-5);
  EXPECT_DOUBLE_EQ(full["lower"].get<double>(), 0.9e-5);
  EXPECT_DOUBLE_EQ(full["upper"].get<double>(), 1.2e-5);
  std::vector<std::string> texts;
  for (const TableCell& cell : table.rows[4]) texts.push_back(cell.text);
  EXPECT_THAT(texts, ElementsAre("full", "1", "100", "10.0 µs", "9.00 µs … 12.0 µs", "80.0 kB"));
  EXPECT_EQ(table.rows[5].back().text, "not told");
  EXPECT_TRUE(j["rows"][5]["bytes"].is_null());
  EXPECT_NEAR(j["monte_carlo"]["steps_per_second"].get<double>(), 1e7, 1e-3);
  EXPECT_NEAR(j["monte_carlo"]["reference_steps_per_second"].get<double>(), 1e7 / 6.0, 1e-3);
  EXPECT_NEAR(j["threads"][1]["runs_per_second"].get<double>(), 1e3 / 0.3, 1e-6);
  EXPECT_EQ(table_of(document, "over threads").rows.at(1).at(3).text, "3.33");
  EXPECT_THAT(table_of(document, "Monte Carlo").notes.at(0), HasSubstr("6.00 × the plain loop"));
}

TEST(TimingReport, WhatCouldNotBeFittedOrDoesNotCrossIsNullWithItsReason) {
  const auto j = nlohmann::json::parse(timing_document(quadratic_and_linear()).json());
  EXPECT_EQ(j["slopes"]["full"]["value"], 2.0);
  for (const char* number : {"value", "lower", "upper"}) EXPECT_TRUE(j["slopes"]["naive"][number].is_null());
  EXPECT_THAT(j["slopes"]["naive"]["reason"].get<std::string>(), HasSubstr("three sizes"));
  EXPECT_EQ(j["slopes"].size(), kTimedFilters.size());
  EXPECT_EQ(j["crossovers"][0]["landmarks"], 20.0);
  EXPECT_FALSE(j["crossovers"][0].contains("reason"));
  EXPECT_TRUE(j["crossovers"][1]["landmarks"].is_null());
  EXPECT_THAT(j["crossovers"][1]["reason"].get<std::string>(), HasSubstr("map is the faster one"));
}

TEST(TimingReport, TheFigureHasAPanelForEachNumberObserved) {
  const Figure figure = figure_of(timing_document(quadratic_and_linear()), "steps");
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_EQ(figure.panels[0].title.text, "1 landmark observed");
  const Series& full = figure.panels[0].series.at(1);
  EXPECT_EQ(full.label.text, "full, slope 2.00");
  EXPECT_THAT(full.x, ElementsAre(10.0, 100.0, 1000.0));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(full.y[i] / (1e-3 * full.x[i] * full.x[i]), 1.0, 1e-12);
  EXPECT_EQ(figure.panels[1].series.at(1).label.text, "full") << "no law was fitted";
}

// After all the measuring.
TEST(TimingReport, AFigureOfManyNumbersObservedCanBeDrawn) {
  TimingResult result = quadratic_and_linear();
  for (Index observed = 2; observed < 100; ++observed)
    result.filters.push_back({TimedFilter::map, 100, observed, about(1e-6), std::nullopt});
  const Figure figure = figure_of(timing_document(result), "steps");
  EXPECT_NO_THROW(validate(figure));
  EXPECT_EQ(figure.cols, 3);
  EXPECT_EQ(figure.panels.size(), kMostPanels);
  EXPECT_THAT(figure.caption, HasSubstr("Of 99 panels the first 40 are shown."));
}

TEST(TimingReport, WithFewSizesThereIsNoLawAndAnInterruptedOneSaysSo) {
  TimingResult result = quadratic_and_linear();
  result.filters.resize(4);
  result.growth.clear();
  result.crossovers.clear();
  result.complete = false;
  const Document document = timing_document(result);
  EXPECT_EQ(document.answer.text, "Too few sizes of the map were timed for a law of growth");
  EXPECT_THAT(figure_of(document, "steps").caption, Not(HasSubstr("Slopes")));
  EXPECT_THAT(figure_of(timing_document(quadratic_and_linear()), "steps").caption, HasSubstr("Slopes"));
  const ReportTable growth = table_of(document, "How the time of a step grows");
  EXPECT_TRUE(growth.columns.empty()) << "no heading over nothing";
  EXPECT_THAT(growth.notes, ElementsAre("No slope is fitted to so few sizes."));
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["complete"], false);
  EXPECT_EQ(j["rows"].size(), 4U);
  EXPECT_TRUE(j["slopes"]["map"]["value"].is_null());
  const auto calls_out = [](const Document& shown) {
    return std::ranges::any_of(
        shown.parts(), [](const DocumentPart& part) { return std::holds_alternative<part::Callout>(part); });
  };
  EXPECT_TRUE(calls_out(document));
  EXPECT_FALSE(calls_out(timing_document(quadratic_and_linear())));
}

}  // namespace
}  // namespace credence::internal
