#include "reports/document/replay/carpark_study_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "datasets/replay/carpark_findings.h"
#include "tests/datasets/replay/carpark_traces.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr CarparkVariant kFigureFive{Inflation::full, InflationSolution::min_trace, 0};
constexpr CarparkVariant kFigureSix{Inflation::map, InflationSolution::min_trace, 0};

std::vector<std::string> carpark_row(const ReportTable& table, std::size_t row) {
  std::vector<std::string> texts;
  for (const TableCell& cell : table.rows.at(row)) texts.push_back(cell.text);
  return texts;
}

TEST(CarparkStudyReport, AnswersHowMuchOfWhatWasToBeShownHolds) {
  CarparkStudy study = carpark_study_that_holds();
  const ReportAnswer all = carpark_study_document(study).answer;
  EXPECT_EQ(all.tone, CellTone::good);
  EXPECT_EQ(all.text, "13 of the 13 things that the replays were to show hold");
  study.horizon[3].result.ok = false;
  const Document document = carpark_study_document(study);
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  EXPECT_EQ(document.answer.text, "12 of the 13 things that the replays were to show hold");
  const ReportTable findings = table_of(document, "What was to be shown");
  ASSERT_EQ(findings.rows.size(), 13U);
  int alarms = 0;
  for (const auto& row : findings.rows) {
    EXPECT_EQ(row[2].text, row[2].tone == CellTone::alarm ? "no" : "yes");
    alarms += row[2].tone == CellTone::alarm ? 1 : 0;
  }
  EXPECT_EQ(alarms, 1);
}

TEST(CarparkStudyReport, EveryVariantHasARowForBothInitialCovariances) {
  CarparkStudy study = carpark_study_that_holds();
  for (CarparkVariantRun& run : study.runs) {
    if (run.variant == kFigureFive && run.initial == carpark_initials()[1]) {
      run.result.covariance.vehicle_final = 1.5;
      run.result.vehicle_nees.add(0.75);
      run.result.landmark_rms = 0.25;
    }
  }
  const ReportTable table = table_of(carpark_study_document(study), "All variants");
  ASSERT_EQ(table.rows.size(), 42U) << "21 variants";
  bool found = false;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto row = carpark_row(table, i);
    if (row[0] != inflation_words(kFigureFive) || row[1] != "partial" || row[3] != "0.316 m, 15°") continue;
    found = true;
    EXPECT_THAT(row, ElementsAre("full, exact minimal trace", "partial", "Figure 5", "0.316 m, 15°", "100.0",
                                 "1.500", "70.00", "0.1400", "0.7500", "0.2500", "0.05000"));
  }
  EXPECT_TRUE(found);
}

// With one anchor the map is 2.5 times as uncertain from a heading of 15°, with two it is not.
TEST(CarparkStudyReport, IndependenceIsTheRatioOverAllInitialCovariances) {
  const Document document = carpark_study_document(carpark_study_that_holds());
  const ReportTable table = table_of(document, "Does the map depend on P0?");
  ASSERT_EQ(table.columns.size(), 8U);
  EXPECT_EQ(table.columns[3].title, "0.05 m, 15°");
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_THAT(carpark_row(table, 0),
              ElementsAre("none", "1 anchor", "20.00", "50.00", "50.00", "20.00", "50.00", "2.500"));
  EXPECT_THAT(carpark_row(table, 5), ElementsAre("map, exact minimal trace", "2 anchors", "20.00", "20.00",
                                                 "20.00", "20.00", "20.00", "1.000"));
  const Figure figure = figure_of(document, "carpark-independence");
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_THAT(figure.panels[0].series.at(0).y, ElementsAre(1.0, 2.5, 2.5, 1.0, 2.5));
  EXPECT_THAT(figure.panels[1].series.at(4).y, ElementsAre(1.0, 1.0, 1.0, 1.0, 1.0));
  EXPECT_EQ(figure.panels[0].series.size(), 6U) << "a line and points for each of three";
}

TEST(CarparkStudyReport, TheLongHorizonIsToldAtItsEndsAndHalfWay) {
  CarparkStudy study = carpark_study_that_holds();
  study.horizon.push_back({{Inflation::map, InflationSolution::batch, 0}, {}});  // came to no loop
  study.plan.scan_stride = 5;
  const Document document = carpark_study_document(study);
  const ReportTable table = table_of(document, "Long horizon: the same way forth and back 10 times");
  ASSERT_EQ(table.rows.size(), 5U);
  EXPECT_THAT(carpark_row(table, 0),
              ElementsAre("none", "5.000", "4.000", "4.000", testing::_, "1.000", "flat"));
  EXPECT_THAT(carpark_row(table, 1),
              ElementsAre("full, pairwise", "1.000", "4.000", "32.00", testing::_, "2.000", "exponential"));
  EXPECT_THAT(carpark_row(table, 2)[6], "linear");
  EXPECT_THAT(table.notes.front(), HasSubstr("every 5th scan"));
  const Figure figure = figure_of(document, "carpark-horizon");
  EXPECT_NO_THROW(validate(figure));
  EXPECT_THAT(figure.panels.at(0).series.at(2).y, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(figure.panels[0].series[2].label.text, "map, pairwise");
}

TEST(CarparkStudyReport, ThePapersFiguresComeWithBothBounds) {
  CarparkStudy study = carpark_study_that_holds();
  for (CarparkVariantRun& run : study.runs) {
    run.result.steps.resize(2);
    run.result.steps[1].time_s = 1.0;
  }
  const Document document = carpark_study_document(study);
  std::vector<std::string> names;
  std::vector<bool> open;
  for (const DocumentPart& part : document.parts()) {
    if (const auto* fold = std::get_if<part::Fold>(&part)) open.push_back(fold->open);
    const auto* drawn = std::get_if<part::DrawnFigure>(&part);
    if (drawn == nullptr) continue;
    const Figure figure = drawn->make();
    EXPECT_NO_THROW(validate(figure)) << figure.name;
    names.push_back(figure.name);
  }
  EXPECT_THAT(names, ElementsAre("carpark-independence", "carpark-horizon", "carpark-figure5-exact",
                                 "carpark-figure6-exact", "carpark-figure7-exact", "carpark-figure8-exact",
                                 "carpark-figure5-pairwise", "carpark-figure6-pairwise",
                                 "carpark-figure7-pairwise", "carpark-figure8-pairwise"));
  EXPECT_THAT(open, ElementsAre(true, false)) << "the pairwise bound is folded up";
  const Figure eight = figure_of(document, "carpark-figure8-exact");
  ASSERT_EQ(eight.panels.size(), 4U);
  EXPECT_EQ(eight.panels[0].title.text, "No inflation");
  EXPECT_EQ(eight.panels[3].title.text, "Figure 7: map, exact minimal trace, 1 anchor");
}

TEST(CarparkStudyReport, TheJsonHasEveryRunFindingAndLoop) {
  CarparkStudy study = carpark_study_that_holds();
  for (CarparkVariantRun& run : study.runs) {
    if (run.variant == kFigureSix) run.result.covariance.landmarks_max = std::nan("");
  }
  const auto j = nlohmann::json::parse(carpark_study_document(study).json());
  EXPECT_EQ(j["dataset"], "carpark");
  EXPECT_EQ(j["findings"].size(), 13U);
  EXPECT_EQ(j["findings"][0]["id"], carpark_findings(study)[0].id);
  EXPECT_EQ(j["findings"][0]["holds"], true);
  ASSERT_EQ(j["variants"].size(), study.runs.size());
  int of_six = 0;
  for (const auto& variant : j["variants"]) {
    if (variant["inflation"] != inflation_words(kFigureSix) || variant["anchors"] != 0) continue;
    ++of_six;
    EXPECT_EQ(variant["figure"], "Figure 6");
    EXPECT_EQ(variant["observations"], 888);
    EXPECT_EQ(variant["covariance"]["landmarks_final"], 60.0);
    EXPECT_TRUE(variant["covariance"]["landmarks_max"].is_null());
    EXPECT_THAT(variant["nis"].get<double>(), DoubleEq(0.14));
  }
  EXPECT_EQ(of_six, 7);
  ASSERT_EQ(j["long_horizon"].size(), 5U);
  EXPECT_EQ(j["long_horizon"][2]["landmarks"].dump(), "[1.0,2.0,3.0,4.0,5.0,6.0]");
  EXPECT_EQ(j["long_horizon"][2]["growth"], "linear");
  EXPECT_THAT(j["long_horizon"][2]["growth_per_loop"].get<double>(), DoubleEq(6.0 / 5.0));
  EXPECT_EQ(j["null_reason"], "null: the number is not finite");
}

}  // namespace
}  // namespace credence::internal
