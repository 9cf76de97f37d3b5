#include "reports/document/checks/selftest_report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/figures/figure_layout.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

StudyShare share_of_studies(double value) {
  return {.count = {.inside = std::llround(100.0 * value), .total = 100},
          .interval = {.value = value, .lower = 0.5 * value, .upper = 2.0 * value}};
}

WrongFilterResult wrong_filter(const char* name, std::vector<PowerRow> power) {
  WrongFilterResult filter{.name = name};
  filter.caught = share_of_studies(0.96);
  filter.direction = Verdict::optimistic;
  filter.direction_right = share_of_studies(1.0);
  filter.named = share_of_studies(0.85);
  filter.causes = {{Cause::bias, 0.85}, {Cause::outliers, 0.04}};
  filter.expected = Cause::bias;
  filter.power = std::move(power);
  filter.ok = true;
  return filter;
}

/// Two tests at two levels; the second wrong filter has two sensors, hence tests of its own.
SelftestResult result_of_two() {
  SelftestResult result{.seed = 3, .studies = 100, .runs = 8};
  result.family_level = 0.001;
  result.complete = result.ok = true;
  for (const char* name : {"NEES", "whiteness"}) {
    for (const double level : {0.05, 0.01}) {
      result.calibration.push_back({name, Exactness::exact, level, share_of_studies(level), true});
    }
  }
  result.wrong_filters = {
      wrong_filter("one sensor", {{"NEES", share_of_studies(0.5)}, {"whiteness", share_of_studies(0.25)}}),
      wrong_filter("two sensors", {{"NEES", share_of_studies(0.125)},
                                   {"whiteness of landmark", share_of_studies(0.75)},
                                   {"whiteness of compass", share_of_studies(1.0)}})};
  return result;
}

TEST(SelftestReport, ACellOfThePowerFigureIsOfTheTestWithItsNumber) {
  const Figure figure = figure_of(selftest_document(result_of_two()), "power");
  const Matrix& cells = figure.panels.at(0).series.at(0).cells;
  ASSERT_EQ(cells.rows(), 2);
  ASSERT_EQ(cells.cols(), 2);
  EXPECT_EQ(cells(0, 0), 50.0);
  EXPECT_EQ(cells(0, 1), 25.0);
  EXPECT_EQ(cells(1, 0), 12.5);
  EXPECT_TRUE(std::isnan(cells(1, 1))) << "the whiteness of two sensors is not that of one";
  EXPECT_NO_THROW(validate(figure));
}

TEST(SelftestReport, ARateThatIsNearlyNoneHasNoExponent) {
  SelftestResult result = result_of_two();
  result.calibration[0].measured.interval = {.value = 0.01, .lower = 2.37e-8, .upper = 0.147};
  const Document document = selftest_document(result);
  std::string range;
  for (const DocumentPart& part : document.parts()) {
    const auto* table = std::get_if<ReportTable>(&part);
    if (table != nullptr && range.empty()) range = table->rows.at(0).at(4).text;
  }
  EXPECT_EQ(range, "0.00 … 14.7");
}

TEST(SelftestReport, EveryWrongFilterIsNamedInThePowerFigure) {
  SelftestResult result = result_of_two();
  result.wrong_filters.resize(13, result.wrong_filters.front());
  const FigureLayout layout = lay_out(figure_of(selftest_document(result), "power"), 620.0);
  EXPECT_EQ(layout.panels.at(0).y.ticks.size(), 13U);
}

TEST(SelftestReport, AFilterWithFewerTestsThanTheFirstLeavesTheOthersOpen) {
  SelftestResult result = result_of_two();
  result.wrong_filters[1].power.clear();
  const Figure figure = figure_of(selftest_document(result), "power");
  const Matrix& cells = figure.panels.at(0).series.at(0).cells;
  EXPECT_TRUE(std::isnan(cells(1, 0)) && std::isnan(cells(1, 1)));
}

TEST(SelftestReport, EveryTestHasOneRowWithItsRateAtBothLevels) {
  SelftestResult result = result_of_two();
  result.calibration[3].ok = false;  // whiteness at 1 %
  const ReportTable table = table_of(selftest_document(result), "False alarms");
  ASSERT_EQ(table.rows.size(), 2U);
  std::vector<std::string> texts;
  for (const TableCell& cell : table.rows[1]) texts.push_back(cell.text);
  EXPECT_THAT(texts, ElementsAre("2", "whiteness", "exact", "5.00", "2.50 … 10.0", "1.00", "0.500 … 2.00",
                                 "OUT OF CALIBRATION"));
  EXPECT_EQ(table.rows[0].back().tone, CellTone::good);
}

TEST(SelftestReport, SaysWhatFailedAndThatVerdictsAreThenNotToBeTrusted) {
  SelftestResult result = result_of_two();
  EXPECT_THAT(selftest_failures(result), IsEmpty());
  EXPECT_EQ(selftest_document(result).answer.tone, CellTone::good);
  EXPECT_EQ(selftest_document(result).answer.text,
            "No test is proved to exceed its false-alarm rate, and the fault of every wrong filter is found");
  result.calibration[3].ok = false;
  result.wrong_filters[1].ok = false;
  EXPECT_THAT(
      selftest_failures(result),
      ElementsAre("\"whiteness\" is out of calibration: 1.00 % false alarms at nominal 1.00 %, true rate "
                  "within 0.500 … 2.00 %",
                  "\"two sensors\" is caught in 96.0 % and its cause named in 85.0 % of the studies"));
  const Document document = selftest_document(result);
  EXPECT_EQ(document.answer.tone, CellTone::alarm);
  EXPECT_THAT(document.answer.text, HasSubstr("2 tests are out of calibration or miss what is wrong"));
}

TEST(SelftestReport, FiltersWhosePIsRightAreNamed) {
  SelftestResult result = result_of_two();
  const auto note = [&] { return table_of(selftest_document(result), "wrong on purpose").notes.at(0); };
  EXPECT_THAT(note(), HasSubstr("99 % of those caught in the right direction."));
  result.wrong_filters[1].caught_most = 0.1;
  EXPECT_THAT(note(), HasSubstr("right direction; where P is right, and the cause alone is to be found (two "
                                "sensors), above 10 % caught."));
}

TEST(SelftestReport, TheDocumentHoldsEveryShareWithItsInterval) {
  const auto j = nlohmann::ordered_json::parse(selftest_document(result_of_two()).json());
  EXPECT_EQ(j["tests"].size(), 4U);
  EXPECT_EQ(
      j["tests"][0].dump(),
      R"({"name":"NEES","nominal":0.05,"measured":0.05,"lower":0.025,"upper":0.1,"studies":100,"law":"exact","ok":true})");
  EXPECT_EQ(j["wrong_filters"][1]["power"].size(), 3U);
  EXPECT_EQ(j["wrong_filters"][0]["direction"]["expected"], "optimistic");
  EXPECT_EQ(j["wrong_filters"][0]["causes"].size(), 2U) << "the table leaves out what is below 5 %";
  const ReportTable table = table_of(selftest_document(result_of_two()), "wrong on purpose");
  EXPECT_THAT(table.rows[0][4].text, HasSubstr("(85.0 %)"));
  EXPECT_THAT(table.rows[0][4].text, testing::Not(HasSubstr(";")));
}

}  // namespace
}  // namespace credence::internal
