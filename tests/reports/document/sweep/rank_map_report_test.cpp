#include "reports/document/sweep/rank_map_report.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

/// Rank ΔP up to `bounded_to` is bounded, what both conditions say as well, unless told.
RankMapCell cell(Index rank_O, Index rank_P, Index bounded_to,
                 Observability observability = Observability::partial) {
  RankMapCell c;
  c.observability = observability;
  c.landmarks = c.observability_rank = rank_O;
  c.inflation_rank = rank_P;
  c.bounded = c.predicted = c.paper = rank_P <= bounded_to;
  c.growth_per_step = c.bounded ? 0.0 : 0.5;
  c.growth_exponent = c.bounded ? 0.0 : 1.0;
  c.nees_ratio = 0.9;
  return c;
}

/// Ranks O of 1 and 2; all of rank ΔP < rank O are bounded, and eq. (22) takes those of equal rank for
/// bounded.
std::vector<RankMapCell> small_map() {
  std::vector<RankMapCell> cells;
  for (Index rank_O = 1; rank_O <= 2; ++rank_O) {
    for (Index rank_P = 0; rank_P <= rank_O + 1; ++rank_P) {
      cells.push_back(cell(rank_O, rank_P, rank_O - 1));
      cells.back().paper = rank_P <= rank_O;
    }
  }
  return cells;
}

std::vector<std::string> rank_map_row(const ReportTable& table, std::size_t row) {
  std::vector<std::string> texts;
  for (const TableCell& each : table.rows.at(row)) texts.push_back(each.text);
  return texts;
}

const Series* series_of(const Panel& panel, const std::string& label) {
  for (const Series& series : panel.series) {
    if (series.label.text == label) return &series;
  }
  return nullptr;
}

TEST(RankMapReport, CountsWhoErrs) {
  std::vector<RankMapCell> cells = small_map();
  EXPECT_EQ(rank_map_answer(cells).text,
            "The exact condition is right in all 7 cells of the map; the paper's eq. (22), rank ΔP ≤ rank O, "
            "errs in 2");
  EXPECT_EQ(rank_map_answer(cells).tone, CellTone::good);
  cells[0].predicted = false;
  EXPECT_THAT(rank_map_answer(cells).text, testing::StartsWith("The exact condition errs in 1 of 7 cells"));
  EXPECT_EQ(rank_map_answer(cells).tone, CellTone::caution);
  EXPECT_THAT(rank_map_answer(std::span(cells).first(1)).text,
              testing::StartsWith("The exact condition errs in the one cell of the map;"));
  cells.push_back(cell(3, 0, 3, Observability::full));
  const ReportTable table = rank_map_table(cells, 0.95);
  EXPECT_THAT(rank_map_row(table, 0), ElementsAre("partial", "anywhere", "7", "3", "1", "2", "0.9000", "0"));
  EXPECT_THAT(rank_map_row(table, 1), ElementsAre("anchored", "anywhere", "1", "1", "0", "0", "0.9000", "0"));
  EXPECT_EQ(table.rows[0][4].tone, CellTone::caution);
}

TEST(RankMapReport, ListsThePlacesWhereAConditionErrsWithAllTheirSeeds) {
  std::vector<RankMapCell> cells = small_map();
  const std::vector<RankMapCell> again = small_map();
  cells.insert(cells.end(), again.begin(), again.end());
  cells[1].growth_per_step = 1.5;  // rank O = rank ΔP = 1, the other seed 0.5
  const ReportTable table = rank_map_disagreements(cells);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_THAT(rank_map_row(table, 0), ElementsAre("partial", "anywhere", "1", "1", "2", "unbounded", "1.000",
                                                  "unbounded", "bounded"));
  EXPECT_THAT(rank_map_row(table, 1), ElementsAre("partial", "anywhere", "2", "2", "2", "unbounded", "0.5000",
                                                  "unbounded", "bounded"));
  cells[1].bounded = true;
  EXPECT_EQ(rank_map_row(rank_map_disagreements(cells), 0)[5], "1 bounded");
}

// As many are bounded as are said to be, but not the same ones.
TEST(RankMapReport, ErrorsOfTwoSeedsDoNotCancel) {
  std::vector<RankMapCell> cells = {cell(1, 0, 1), cell(1, 0, -1)};
  std::swap(cells[0].predicted, cells[1].predicted);
  EXPECT_THAT(rank_map_answer(cells).text, testing::HasSubstr("errs in 2 of 2"));
  EXPECT_EQ(rank_map_disagreements(cells).rows.size(), 1U);
  std::swap(cells[0].predicted, cells[1].predicted);
  EXPECT_TRUE(rank_map_disagreements(cells).rows.empty());
  std::swap(cells[0].paper, cells[1].paper);
  EXPECT_NE(series_of(rank_map_figure(cells).panels.at(0), "eq. (22) errs"), nullptr);
}

TEST(RankMapReport, TheFigureHasTheMeasuredGrowthBothBoundariesAndTheErrors) {
  const Figure figure = rank_map_figure(small_map());
  ASSERT_EQ(figure.panels.size(), 1U);
  EXPECT_NO_THROW(validate(figure));
  const Panel& panel = figure.panels[0];
  const Matrix& growth = panel.series.at(0).cells;  // rank ΔP over rank O
  ASSERT_EQ(growth.rows(), 4);
  ASSERT_EQ(growth.cols(), 2);
  EXPECT_EQ(growth(0, 0), 0.0);
  EXPECT_EQ(growth(1, 0), 0.5);
  EXPECT_EQ(growth(1, 1), 0.0);
  EXPECT_TRUE(std::isnan(growth(3, 0))) << "there is no such cell";
  ASSERT_TRUE(panel.colour_range.has_value());
  EXPECT_EQ(panel.colour_range->low, 0.0) << "no growth is negative";
  EXPECT_EQ(panel.colour_range->high, 0.5);
  const Series* exact = series_of(panel, "exact condition: bounded below");
  const Series* paper = series_of(panel, "eq. (22): bounded below");
  ASSERT_TRUE(exact != nullptr && paper != nullptr);
  EXPECT_THAT(exact->x, ElementsAre(0.5, 1.5, 1.5, 2.5));
  EXPECT_THAT(exact->y, ElementsAre(0.5, 0.5, 1.5, 1.5));
  EXPECT_THAT(paper->y, ElementsAre(1.5, 1.5, 2.5, 2.5));
  const Series* errs = series_of(panel, "eq. (22) errs");
  ASSERT_NE(errs, nullptr);
  EXPECT_THAT(errs->x, ElementsAre(1.0, 2.0));
  EXPECT_THAT(errs->y, ElementsAre(1.0, 2.0));
}

TEST(RankMapReport, WhereNothingGrowsThereIsNoBoundary) {
  const std::vector<RankMapCell> cells = {cell(1, 0, 5), cell(1, 1, 5), cell(2, 1, 5, Observability::full)};
  const Figure figure = rank_map_figure(cells);
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_EQ(figure.panels[0].series.size(), 1U);
  EXPECT_EQ(figure.panels[0].title.text, "partial, anywhere");
  EXPECT_EQ(figure.panels[1].title.text, "anchored, anywhere");
}

TEST(RankMapReport, TheDataHaveEveryCellAndTheCountsOfTheTable) {
  std::vector<RankMapCell> cells = small_map();
  cells[0].nees_ratio = std::nan("");
  const Json j = as_read(rank_map_json(cells, 0.95));
  ASSERT_EQ(j["cells"].size(), 7U);
  EXPECT_TRUE(j["cells"][0]["nees_ratio"].is_null());
  int bounded = 0, errs = 0;
  for (const Json& each : j["cells"]) {
    bounded += each["measured_bounded"].get<bool>() ? 1 : 0;
    errs += each["measured_bounded"] != each["paper_condition_holds"] ? 1 : 0;
  }
  EXPECT_EQ(j["groups"][0]["bounded"], bounded);
  EXPECT_EQ(j["groups"][0]["paper_errs"], errs);
  EXPECT_EQ(j["groups"][0]["exact_errs"], 0);
  EXPECT_EQ(j["cells"][6]["inflation_rank"], 3);
  EXPECT_EQ(j["cells"][6]["observability_rank"], 2);
}

}  // namespace
}  // namespace credence::internal
