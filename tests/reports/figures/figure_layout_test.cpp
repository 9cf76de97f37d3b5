#include "reports/figures/figure_layout.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "core/nan.h"
#include "reports/figures/figure_text.h"

namespace credence::internal {
namespace {

Panel panel_with(int labels, const std::string& y_label) {
  Panel panel;
  panel.title = "title";
  panel.x_label = "step";
  panel.y_label = y_label;
  for (int i = 0; i < labels; ++i) {
    panel.series.push_back(
        line_series("landmark " + std::to_string(i), numbered_role(i), {0, 100}, {0, 1.0 + i}));
  }
  return panel;
}

Figure grid(int rows, int cols, std::vector<Panel> panels) {
  Figure figure;
  figure.name = "grid";
  figure.rows = rows;
  figure.cols = cols;
  figure.panels = std::move(panels);
  return figure;
}

TEST(FigureLayout, AxesOfARowAndAColumnLineUp) {
  const auto layout = lay_out(
      grid(2, 2, {panel_with(1, "a"), panel_with(6, "b"), panel_with(2, ""), panel_with(1, "d")}), 900);
  ASSERT_EQ(layout.panels.size(), 4u);
  EXPECT_EQ(layout.panels[0].box.bottom, layout.panels[1].box.bottom);
  EXPECT_EQ(layout.panels[0].box.top, layout.panels[1].box.top);
  EXPECT_EQ(layout.panels[0].box.left, layout.panels[2].box.left);
  EXPECT_EQ(layout.panels[1].box.right, layout.panels[3].box.right);
}

TEST(FigureLayout, EverythingIsOnTheCanvas) {
  for (const int labels : {0, 1, 5, 30}) {
    const auto layout = lay_out(grid(2, 3, std::vector<Panel>(5, panel_with(labels, "position (m)"))), 1000);
    for (const PanelLayout& panel : layout.panels) {
      EXPECT_GE(panel.box.left, 30.0);
      EXPECT_LE(panel.box.right, 1000.0);
      EXPECT_GE(panel.title_y, 0.0);
      EXPECT_LT(panel.box.bottom, panel.x_label_y);
      EXPECT_LT(panel.x_label_y, layout.height);
      EXPECT_GT(panel.box.height(), 100.0);
      for (const LegendEntry& entry : panel.legend) EXPECT_LT(entry.y, layout.height - 5.0);
    }
  }
}

TEST(FigureLayout, LegendsStandBelowTheirAxesAndAboveTheNextRow) {
  const auto layout = lay_out(grid(2, 1, {panel_with(9, "y"), panel_with(9, "y")}), 600);
  ASSERT_EQ(layout.panels[0].legend.size(), 9u);
  for (const LegendEntry& entry : layout.panels[0].legend) {
    EXPECT_GT(entry.y, layout.panels[0].box.bottom + 20.0);
    EXPECT_LT(entry.y, layout.panels[1].box.top - 10.0);
    EXPECT_GE(entry.x, 0.0);
  }
}

TEST(FigureLayout, ALegendThatTellsNothingNewIsLeftOut) {
  const auto legends_of = [](std::vector<Panel> panels) {
    const auto rows = static_cast<int>(panels.size());
    std::vector<std::size_t> entries;
    for (const PanelLayout& panel : lay_out(grid(rows, 1, std::move(panels)), 600).panels)
      entries.push_back(panel.legend.size());
    return entries;
  };
  using Entries = std::vector<std::size_t>;
  const Panel three = panel_with(3, "y");
  EXPECT_EQ(legends_of({three, three, three}), (Entries{3, 0, 0}));
  EXPECT_EQ(legends_of({three, panel_with(2, "y"), three}), (Entries{3, 2, 3})) << "the last one counts";
  EXPECT_EQ(legends_of({three, panel_with(0, "y"), three}), (Entries{3, 0, 0}));
  const auto changed = [&](const std::function<void(Series&)>& change) {
    Panel other = three;
    change(other.series[1]);
    return legends_of({three, other});
  };
  EXPECT_EQ(changed([](Series& s) { s.y = {7, 8}; }), (Entries{3, 0})) << "other numbers";
  EXPECT_EQ(changed([](Series& s) { s.label = "another"; }), (Entries{3, 3}));
  EXPECT_EQ(changed([](Series& s) { s.role = ColourRole::alarm; }), (Entries{3, 3}));
  EXPECT_EQ(changed([](Series& s) { s.stroke = StrokeStyle::dotted; }), (Entries{3, 3}));
  EXPECT_EQ(changed([](Series& s) { s.kind = SeriesKind::points; }), (Entries{3, 3}));
  EXPECT_EQ(changed([](Series& s) { s.kind = SeriesKind::steps; }), (Entries{3, 0})) << "a line, too";
}

TEST(FigureLayout, WhatCannotBeDrawnIsNotInTheLegend) {
  Panel panel = panel_with(3, "y");
  panel.series[1].y = {kNaN, kNaN};
  const FigureLayout layout = lay_out(grid(1, 1, {panel}), 600);
  const std::vector<LegendEntry>& entries = layout.panels[0].legend;
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].series, 0U);
  EXPECT_EQ(entries[1].series, 2U);
  panel.series[2].y = {0.0, 0.0};  // the lower end of what is unbounded below, on a logarithmic axis
  panel.log_y = true;
  EXPECT_EQ(lay_out(grid(1, 1, {panel}), 600).panels[0].legend.size(), 1U);
  panel.series.push_back(line_series("", panel.series[2].role, {0, 100}, {3, 3}));
  EXPECT_EQ(lay_out(grid(1, 1, {panel}), 600).panels[0].legend.size(), 2U) << "its upper end is seen";
}

TEST(FigureLayout, AnOutlineIsNoLineInTheLegend) {
  Panel panel = panel_with(1, "y");
  panel.series.push_back(panel.series[0]);
  panel.series[1].kind = SeriesKind::polygon;
  EXPECT_TRUE(legend_sample(panel.series[0]).line);
  EXPECT_FALSE(legend_sample(panel.series[0]).outline);
  EXPECT_FALSE(legend_sample(panel.series[1]).line);
  EXPECT_TRUE(legend_sample(panel.series[1]).outline);
  panel.series[1].filled = true;
  EXPECT_FALSE(legend_sample(panel.series[1]).outline);
  EXPECT_TRUE(legend_sample(panel.series[1]).area);
}

TEST(FigureLayout, VerticalLabelsHaveTheHeightThatTheyNeed) {
  const std::string words = "its time per step (µs); grey: none stays consistent";
  Panel heat;
  heat.series = {heat_series({1, 2}, {1, 2}, Matrix::Identity(2, 2))};
  const auto layout_of = [&] { return lay_out(grid(1, 1, {heat}), 378).panels[0]; };
  EXPECT_LT(layout_of().box.height(), text_width(words) - 40.0) << "else there is nothing to see to";
  heat.colour_label = words;
  const double half = 0.5 * text_width(words);
  for (int of_axis = 0; of_axis < 2; ++of_axis) {
    const PanelLayout panel = layout_of();
    const double middle = 0.5 * (panel.box.top + panel.box.bottom);
    EXPECT_GE(middle - half, panel.cell.top - 5.0);  // letters are narrower than their widest font
    EXPECT_LE(middle + half, panel.cell.bottom);
    std::swap(heat.colour_label, heat.y_label);
  }
}

TEST(FigureLayout, MarkersOnLinesTellWhatLinesAre) {
  Panel lines = panel_with(2, "y"), bars = lines;
  for (Series& series : bars.series) {
    series.kind = SeriesKind::error_bars;
    series.lower = series.upper = series.y;
  }
  const FigureLayout once = lay_out(grid(1, 2, {bars, lines}), 900);
  EXPECT_EQ(once.panels[0].legend.size(), 2U);
  EXPECT_TRUE(once.panels[1].legend.empty());
  const FigureLayout twice = lay_out(grid(1, 2, {lines, bars}), 900);
  EXPECT_EQ(twice.panels[0].legend.size(), 2U);
  EXPECT_EQ(twice.panels[1].legend.size(), 2U) << "lines do not tell the markers";
}

TEST(FigureLayout, LegendEntriesDoNotOverlap) {
  const Panel panel = panel_with(9, "y");
  const auto layout = lay_out(grid(1, 1, {panel}), 400);
  const auto& entries = layout.panels[0].legend;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const double end = entries[i - 1].x + entries[i - 1].sample_width + text_width(panel.series[i - 1].label);
    EXPECT_TRUE(entries[i].y > entries[i - 1].y || entries[i].x > end);
  }
}

TEST(FigureLayout, EqualAspectMeansEqualScales) {
  Panel map;
  map.equal_aspect = true;
  map.series = {line_series("", ColourRole::truth, {0, 10}, {0, 70})};
  const auto layout = lay_out(grid(1, 2, {map, panel_with(1, "y")}), 900);
  const PanelLayout& panel = layout.panels[0];
  const double x_scale = panel.box.width() / (panel.x.range.high - panel.x.range.low);
  const double y_scale = panel.box.height() / (panel.y.range.high - panel.y.range.low);
  EXPECT_NEAR(x_scale / y_scale, 1.0, 1e-9);
  EXPECT_LE(panel.x.range.low, 0.0);
  EXPECT_GE(panel.y.range.high, 70.0);
}

TEST(FigureLayout, ColourBarsHaveRoom) {
  Panel heat;
  heat.colour_label = "trace (m²)";
  heat.series = {heat_series({1, 2}, {1, 2}, 3e-5 * Matrix::Identity(2, 2))};
  const auto layout = lay_out(grid(1, 1, {heat}), 600);
  EXPECT_TRUE(layout.panels[0].has_colour_bar);
  EXPECT_GT(layout.panels[0].colour_bar_x, layout.panels[0].box.right);
  EXPECT_LT(layout.panels[0].colour_label_x, 600.0 - 5.0);
}

}  // namespace
}  // namespace credence::internal
