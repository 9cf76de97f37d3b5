#include "reports/figures/figure_painter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "tests/reports/figures/recording_canvas.h"

namespace credence::internal {
namespace {

using testing::Contains;
using testing::SizeIs;

struct Painted {
  RecordingCanvas canvas;
  FigureLayout layout;
  const PanelLayout& panel() const { return layout.panels[0]; }
};

std::unique_ptr<Painted> painted(const Panel& panel) {
  Figure figure;
  figure.name = "test";
  figure.panels = {panel};
  validate(figure);
  auto all = std::make_unique<Painted>();
  all->layout = lay_out(figure, 600.0);
  paint_figure(figure, all->layout, all->canvas);
  return all;
}

std::unique_ptr<Painted> painted(std::vector<Series> series) {
  Panel panel{.title = "Errors", .x_label = "step", .y_label = "error (m²)"};
  panel.series = std::move(series);
  return painted(panel);
}

std::vector<std::string> words_of(const Painted& all) {
  std::vector<std::string> words;
  for (const RecordingCanvas::Words& one : all.canvas.words) words.push_back(one.text);
  return words;
}

// Whether something in the colour of `role` is drawn at the height of a legend entry, left of its words.
bool has_swatch(const Painted& all, const LegendEntry& entry, ColourRole role) {
  const auto beside = [&](const CanvasPath& path) {
    return std::ranges::all_of(path, [&](const CanvasPoint& p) {
      return std::abs(p.y - entry.y) <= 6.0 && p.x >= entry.x - 1e-9 &&
             p.x <= entry.x + entry.sample_width + 1e-9;
    });
  };
  const auto rgb = style_of(role).rgb;
  return std::ranges::any_of(all.canvas.lines,
                             [&](const auto& l) { return l.pen.rgb == rgb && beside(l.path); }) ||
         std::ranges::any_of(all.canvas.areas,
                             [&](const auto& a) { return a.brush.rgb == rgb && beside(a.outline); });
}

TEST(FigurePainter, ACurveIsDrawnWhereItsNumbersAre) {
  const auto all = painted({line_series("", ColourRole::estimate, {0, 10, 20}, {0, 4, 2})});
  const auto lines = all->canvas.lines_of(ColourRole::estimate);
  ASSERT_EQ(lines.size(), 1u);
  const CanvasBox& box = all->panel().box;
  EXPECT_DOUBLE_EQ(lines[0].front().x, box.left);
  EXPECT_DOUBLE_EQ(lines[0][1].x, 0.5 * (box.left + box.right));
  EXPECT_DOUBLE_EQ(lines[0].back().x, box.right);
  EXPECT_LT(lines[0][1].y, lines[0][2].y) << "4 stands above 2";
}

TEST(FigurePainter, GapsBreakACurveAndALonePointIsAMarker) {
  const auto all = painted(
      {line_series("", ColourRole::estimate, {1, 2, 3, 4, 5, 6, 7}, {1, 2, kNaN, 2, kNaN, 1, INFINITY})});
  const auto lines = all->canvas.lines_of(ColourRole::estimate);
  EXPECT_THAT(lines, testing::UnorderedElementsAre(SizeIs(2), SizeIs(1), SizeIs(1)));
  const auto band =
      painted({band_series("", ColourRole::bound, {1, 2, 3, 4, 5}, {0, 0, kNaN, 0, 0}, {1, 1, 1, 1, 1})});
  EXPECT_EQ(band->canvas.areas.size(), 2u);
}

TEST(FigurePainter, LogAxesShowEqualFactorsAtEqualDistances) {
  Panel panel{.log_x = true, .log_y = true};
  panel.series = {line_series("", ColourRole::third, {1, 10, 100, 1000}, {1e-3, 1e-1, 1e-2, 1e3}),
                  line_series("", ColourRole::estimate, {1, 10, 100}, {1, 0, -1})};
  const auto all = painted(panel);
  const CanvasPath line = all->canvas.lines_of(ColourRole::third).at(0);
  ASSERT_EQ(line.size(), 4u);
  EXPECT_NEAR(line[1].x - line[0].x, line[3].x - line[2].x, 1e-9);
  EXPECT_NEAR(line[0].y - line[1].y, 2.0 * (line[2].y - line[1].y), 1e-9);
  EXPECT_THAT(all->canvas.lines_of(ColourRole::estimate), testing::ElementsAre(SizeIs(1)))
      << "only the positive value has a place";
}

TEST(FigurePainter, StepsHoldTheirValueUpToTheNext) {
  const auto all = painted({step_series("", ColourRole::exact, {0, 1, 2}, {1, 3, 3})});
  const CanvasPath line = all->canvas.lines_of(ColourRole::exact).at(0);
  ASSERT_EQ(line.size(), 4u) << "the last two steps are one line";
  EXPECT_EQ(line[0].y, line[1].y);
  EXPECT_EQ(line[1].x, line[2].x);
}

TEST(FigurePainter, NothingIsDrawnOutsideTheAxes) {
  Panel panel{.x_range = AxisRange{0, 1}, .y_range = AxisRange{0, 1}};
  const FigureData x{-1, 0.5, 0.6, 3};
  const FigureData y{-7, 0.5, 1e300, 0.2};
  Series filled = polygon_series("", ColourRole::fifth, x, y);
  filled.filled = true;
  panel.series = {line_series("", ColourRole::first, x, y),
                  point_series("", ColourRole::second, x, y),
                  band_series("", ColourRole::third, x, y, {1, 1, 1, 1}),
                  error_bar_series("", ColourRole::fourth, x, y, {-9, -9, -9, -9}, {9, 9, 9, 9}),
                  level_series("", ColourRole::sixth, 2.0),
                  upright_series("", ColourRole::sixth, -2.0),
                  text_series(ColourRole::alarm, x, y, {"out", "in", "out", "out"}),
                  filled};
  const auto all = painted(panel);
  const CanvasBox box = all->panel().box;
  const auto inside = [&](const CanvasPath& path) {
    return std::ranges::all_of(path, [&](const CanvasPoint& p) {
      constexpr double kMarker = 4.0;  // the middle of a marker is inside, not all of it
      return p.x >= box.left - kMarker && p.x <= box.right + kMarker && p.y >= box.top - kMarker &&
             p.y <= box.bottom + kMarker;
    });
  };
  for (const ColourRole role : {ColourRole::first, ColourRole::second, ColourRole::third, ColourRole::fourth,
                                ColourRole::fifth, ColourRole::sixth}) {
    for (const CanvasPath& line : all->canvas.lines_of(role)) EXPECT_TRUE(inside(line));
  }
  for (const auto& area : all->canvas.areas) EXPECT_TRUE(inside(area.outline));
  EXPECT_TRUE(all->canvas.lines_of(ColourRole::sixth).empty());
  EXPECT_THAT(words_of(*all), Contains("in"));
  EXPECT_THAT(words_of(*all), testing::Not(Contains("out")));
}

TEST(FigurePainter, WordsOnAHeatMapCanBeRead) {
  Panel panel{.x_range = AxisRange{0.5, 2.5}, .y_range = AxisRange{0.5, 1.5}};
  panel.series = {heat_series({1, 2}, {1}, Matrix{{0.0, 1.0}}),
                  text_series(ColourRole::alarm, {1, 2}, {1, 1}, {"low", "high"})};
  const auto all = painted(panel);
  for (const auto& words : all->canvas.words) {
    if (words.text == "low") {
      EXPECT_EQ(words.lettering.rgb, 0xffffffU) << "on the dark end of the scale";
    } else if (words.text == "high") {
      EXPECT_EQ(words.lettering.rgb, 0x000000U) << "on the light one";
    }
  }
  EXPECT_THAT(words_of(*all), testing::IsSupersetOf({"low", "high"}));
}

TEST(FigurePainter, ManyPointsBecomeAFewWithTheirExtremes) {
  FigureData x, y;
  for (int i = 0; i < 200000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(0.37 * i));
  }
  y[77777] = 123.25;
  y[150001] = -77.125;
  const auto heights = [](const std::vector<CanvasPath>& lines) {
    double top = 1e9, bottom = -1e9;
    for (const CanvasPath& line : lines) {
      for (const CanvasPoint& p : line) {
        top = std::min(top, p.y);
        bottom = std::max(bottom, p.y);
      }
    }
    return bottom - top;
  };
  for (const Series& series :
       {line_series("", ColourRole::first, x, y), point_series("", ColourRole::first, x, y)}) {
    const auto all = painted({series});
    const auto lines = all->canvas.lines_of(ColourRole::first);
    std::size_t points = 0;
    for (const CanvasPath& line : lines) points += line.size();
    EXPECT_LT(points, 5000u);
    // The range has 5 % of room at both ends.
    EXPECT_NEAR(heights(lines), all->panel().box.height() / 1.1, 1e-6);
  }
}

TEST(FigurePainter, EverySeriesStandsInTheLegendWithItsSwatch) {
  Series filled = polygon_series("area", ColourRole::alarm, {1, 2, 2}, {1, 1, 2});
  filled.filled = true;
  const FigureData x{1, 2, 3};
  const std::vector<Series> series{band_series("bounds", ColourRole::bound, x, {0, 0, 0}, {2, 2, 2}),
                                   line_series("line", ColourRole::estimate, x, x),
                                   step_series("steps", ColourRole::exact, x, x),
                                   point_series("points", ColourRole::measurement, x, x),
                                   level_series("level", ColourRole::neutral, 2),
                                   upright_series("upright", ColourRole::sixth, 2),
                                   error_bar_series("bars", ColourRole::second, x, x, x, x),
                                   filled,
                                   line_series("", ColourRole::truth, x, x)};
  const auto all = painted(series);
  const auto& legend = all->panel().legend;
  ASSERT_EQ(legend.size(), series.size() - 1) << "no entry without a label";
  const std::vector<std::string> words = words_of(*all);
  for (const LegendEntry& entry : legend) {
    const Series& one = series[entry.series];
    EXPECT_THAT(words, Contains(one.label.text));
    EXPECT_TRUE(has_swatch(*all, entry, one.role)) << one.label.text;
  }
}

TEST(FigurePainter, BoundsAreDashedAndTruthIsSolid) {
  const auto all = painted({line_series("", ColourRole::bound, {0, 1}, {0, 1}),
                            line_series("", ColourRole::truth, {0, 1}, {1, 0})});
  EXPECT_EQ(all->canvas.lines_of(ColourRole::bound).size(), 1u);
  EXPECT_EQ(all->canvas.lines_of(ColourRole::truth).size(), 1u);
  for (const auto& line : all->canvas.lines) {
    const bool is_bound = line.pen.rgb == style_of(ColourRole::bound).rgb;
    EXPECT_EQ(line.pen.stroke, is_bound ? StrokeStyle::dashed : StrokeStyle::solid);
  }
}

TEST(FigurePainter, MarkersDifferInShape) {
  std::vector<std::size_t> sizes;
  for (const auto shape : {MarkerShape::dot, MarkerShape::plus, MarkerShape::cross, MarkerShape::square,
                           MarkerShape::triangle, MarkerShape::diamond}) {
    Series points = point_series("", ColourRole::first, {1, 2}, {1, 2});
    points.marker = shape;
    const auto all = painted({points});
    const bool area =
        shape == MarkerShape::square || shape == MarkerShape::triangle || shape == MarkerShape::diamond;
    if (area) {
      ASSERT_EQ(all->canvas.areas.size(), 2u);
      EXPECT_EQ(all->canvas.areas[0].outline.size(), shape == MarkerShape::triangle ? 3u : 4u);
    } else {
      EXPECT_EQ(all->canvas.lines_of(ColourRole::first).size(), shape == MarkerShape::dot ? 2u : 4u);
    }
  }
}

TEST(FigurePainter, HeatMapsFillTheirCellsAndHaveAScale) {
  Panel panel{.log_x = true, .colour_label = "trace (m²)"};
  panel.series = {heat_series({1, 10, 100}, {1, 2}, Matrix{{0, 2, 3}, {4, kNaN, 10}})};
  const auto all = painted(panel);
  const auto is_cell = [&](const RecordingCanvas::Area& a) {
    return std::ranges::all_of(a.outline,
                               [&](const CanvasPoint& p) { return p.x <= all->panel().box.right; });
  };
  const auto colours = [&](std::uint32_t rgb) {
    return std::ranges::count_if(all->canvas.areas,
                                 [&](const auto& a) { return is_cell(a) && a.brush.rgb == rgb; });
  };
  EXPECT_EQ(std::ranges::count_if(all->canvas.areas, is_cell), 6);
  EXPECT_EQ(colours(kMissingColour), 1);
  EXPECT_EQ(colours(sequential_colours().front()), 1);
  EXPECT_EQ(colours(sequential_colours().back()), 1);
  EXPECT_GT(all->canvas.areas.size(), 20u) << "the colour bar";
  EXPECT_THAT(words_of(*all), Contains("trace (m²)"));
}

TEST(FigurePainter, AnEmptyPanelSaysSo) {
  for (const auto& series : {std::vector<Series>{},
                             {line_series("", ColourRole::first, {1, 2}, {kNaN, INFINITY})},
                             {line_series("", ColourRole::first, {}, {})}}) {
    EXPECT_THAT(words_of(*painted(series)), Contains("no finite data"));
  }
  EXPECT_THAT(words_of(*painted({level_series("", ColourRole::first, 1)})),
              testing::Not(Contains("no finite data")));
}

}  // namespace
}  // namespace credence::internal
