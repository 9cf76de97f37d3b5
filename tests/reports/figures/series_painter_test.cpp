#include "reports/figures/series_painter.h"

#include <gmock/gmock.h>

#include <memory>

#include "core/nan.h"
#include "reports/figures/figure_clip.h"
#include "reports/figures/figure_text.h"
#include "tests/reports/figures/recording_canvas.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Ten units of x and five of y on a box of 100 × 100: (x, y) lies at (100 + 10 x, 150 − 20 y).
struct SeriesOnPaper {
  explicit SeriesOnPaper(const std::vector<Series>& all) {
    layout.box = {100.0, 200.0, 50.0, 150.0};
    layout.x.range = {0.0, 10.0};
    layout.y.range = {0.0, 5.0};
    layout.colour.range = {0.0, 1.0};
    SeriesPainter painter(layout, canvas);
    painter.keep_clear({.series = all});
    for (const Series& series : all) painter.paint(series);
    has_painted = painter.has_painted();
  }
  std::vector<CanvasPath> outlines() const {
    std::vector<CanvasPath> found;
    for (const RecordingCanvas::Area& area : canvas.areas) found.push_back(area.outline);
    return found;
  }
  PanelLayout layout;
  RecordingCanvas canvas;
  bool has_painted = false;
};

std::unique_ptr<RecordingCanvas> sample_of(const Series& series) {
  const PanelLayout layout;
  auto canvas = std::make_unique<RecordingCanvas>();
  SeriesPainter painter(layout, *canvas);
  painter.paint_sample(series, {.series = 0, .x = 20.0, .y = 40.0, .sample_width = 30.0});
  EXPECT_FALSE(painter.has_painted()) << "a legend is no data";
  return canvas;
}

TEST(SeriesPainter, LevelsAndUprightsCrossTheBox) {
  Series level = level_series("", ColourRole::bound, 2.0);
  level.weight = 3.0;
  const SeriesOnPaper paper({level, upright_series("", ColourRole::estimate, 4.0)});
  EXPECT_THAT(paper.canvas.lines_of(ColourRole::bound), ElementsAre(CanvasPath{{100, 110}, {200, 110}}));
  EXPECT_THAT(paper.canvas.lines_of(ColourRole::estimate), ElementsAre(CanvasPath{{140, 150}, {140, 50}}));
  EXPECT_DOUBLE_EQ(paper.canvas.lines[0].pen.width, 3.0 * style_of(ColourRole::bound).width);
  EXPECT_TRUE(paper.has_painted);
  const SeriesOnPaper above({level_series("", ColourRole::bound, 5.5)});
  EXPECT_THAT(above.canvas.lines, IsEmpty());
  EXPECT_FALSE(above.has_painted);
}

// The second bar has no lower end and the third leaves the box at its top.
TEST(SeriesPainter, ErrorBarsAreSolidAndNeedBothEnds) {
  Series bars = error_bar_series("", ColourRole::estimate, {1, 2, 3}, {2, 2, 2}, {1, kNaN, 1}, {3, 3, 9});
  bars.stroke = StrokeStyle::dashed;
  bars.marker = MarkerShape::square;
  const SeriesOnPaper paper({bars});
  EXPECT_THAT(paper.canvas.lines_of(ColourRole::estimate),
              ElementsAre(CanvasPath{{110, 130}, {110, 90}}, CanvasPath{{130, 130}, {130, 50}}));
  EXPECT_EQ(paper.canvas.lines[0].pen.stroke, StrokeStyle::solid);
  EXPECT_THAT(paper.canvas.areas, SizeIs(3)) << "a square at each of the three means";
}

TEST(SeriesPainter, WhatStandsAsideIsDrawnToTheRightOfItsPlace) {
  Series bars = error_bar_series("", ColourRole::estimate, {1}, {2}, {1}, {3});
  Series line = line_series("", ColourRole::bound, {1, 2}, {2, 2});
  bars.aside = line.aside = 3.0;
  const SeriesOnPaper paper({bars, line});
  EXPECT_EQ(paper.canvas.lines_of(ColourRole::estimate).at(0), (CanvasPath{{113, 130}, {113, 90}}));
  EXPECT_THAT(paper.canvas.lines_of(ColourRole::bound), ElementsAre(CanvasPath{{113, 110}, {123, 110}}));
}

TEST(SeriesPainter, WordsThatWouldLieOnOthersStandInAnotherCorner) {
  const SeriesOnPaper paper({text_series(ColourRole::first, {5}, {3}, {"12"}),
                             text_series(ColourRole::second, {5, 5.1}, {3, 3}, {"13", "14"}),
                             text_series(ColourRole::third, {1}, {3}, {"15"})});
  const auto& words = paper.canvas.words;
  ASSERT_THAT(words, SizeIs(4));
  EXPECT_EQ(words[0].at, (CanvasPoint{155, 85}));
  EXPECT_GT(words[1].at.y, 90.0) << "below";
  EXPECT_EQ(words[2].lettering.anchor, TextAnchor::end) << "to the left";
  EXPECT_EQ(words[3].at, (CanvasPoint{115, 85})) << "nothing is near";
}

// Fifteen estimators, most of which do as well as each other.
TEST(SeriesPainter, WordsOfACrowdStandApartAndAreLedTo) {
  std::vector<Series> crowd;
  for (int i = 0; i < 12; ++i) {
    const double x = 5.0 + 0.05 * i, y = 2.5 + 0.02 * (i % 3);
    crowd.push_back(error_bar_series("", ColourRole::first, {x}, {y}, {y - 1.0}, {y + 1.0}));
    crowd.push_back(text_series(ColourRole::second, {x}, {y}, {std::to_string(i + 1)}));
  }
  const SeriesOnPaper paper(crowd);
  const auto& words = paper.canvas.words;
  ASSERT_THAT(words, SizeIs(12));
  const auto box_of = [](const RecordingCanvas::Words& w) {
    const double width = text_width(w.text);
    const double left = w.lettering.anchor == TextAnchor::end ? w.at.x - width : w.at.x;
    return CanvasBox{left, left + width, w.at.y - 9.0, w.at.y + 3.0};
  };
  for (std::size_t i = 0; i < words.size(); ++i) {
    const CanvasBox a = box_of(words[i]);
    EXPECT_TRUE(is_inside({a.left, a.top}, paper.layout.box)) << i;
    EXPECT_TRUE(is_inside({a.right, a.bottom}, paper.layout.box)) << i;
    for (std::size_t j = 0; j < i; ++j) {
      const CanvasBox b = box_of(words[j]);
      EXPECT_FALSE(a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
          << words[i].text << " lies on " << words[j].text;
    }
  }
  const auto leads = paper.canvas.lines_of(ColourRole::second);
  EXPECT_GT(leads.size(), 4U) << "few of them have a place beside their point";
  for (const CanvasPath& lead : leads) {
    ASSERT_THAT(lead, SizeIs(2));
    EXPECT_GE(lead[0].x, 150.0);
    EXPECT_LE(lead[0].x, 155.5) << "from the point";
  }
}

TEST(SeriesPainter, WordsKeepOffTheMarkersOfOthers) {
  const auto beside = [](double other) {
    const SeriesOnPaper paper({text_series(ColourRole::first, {5}, {3}, {"12"}),
                               point_series("", ColourRole::second, {5, other}, {3, 3.5})});
    return paper.canvas.words.at(0).at;
  };
  EXPECT_EQ(beside(2.0), (CanvasPoint{155, 85})) << "nothing is near";
  EXPECT_GT(beside(6.0).y, 90.0) << "below";
}

TEST(SeriesPainter, ABandIsAnAreaForEachUnbrokenStretch) {
  const SeriesOnPaper paper(
      {band_series("", ColourRole::estimate, {0, 2, 4, 6, 8}, {1, 1, kNaN, 0, 0}, {2, 3, 3, 1, 2})});
  EXPECT_THAT(paper.outlines(), ElementsAre(CanvasPath{{100, 110}, {120, 90}, {120, 130}, {100, 130}},
                                            CanvasPath{{160, 130}, {180, 110}, {180, 150}, {160, 150}}));
  EXPECT_EQ(paper.canvas.areas[0].brush.opacity, style_of(ColourRole::estimate).tint);
  EXPECT_THAT(paper.canvas.lines, IsEmpty());
}

// Where every second step has no data there are no stretches, and markers of bounds would look like data.
TEST(SeriesPainter, LonePointsOfBoundsAreShortStrokesAndOfDataMarkers) {
  const FigureData x = {1, 2, 3}, y = {1, kNaN, 2};
  const SeriesOnPaper bound({line_series("", ColourRole::bound, x, y)});
  EXPECT_THAT(
      bound.canvas.lines_of(ColourRole::bound),
      ElementsAre(CanvasPath{{109.25, 130}, {110.75, 130}}, CanvasPath{{129.25, 110}, {130.75, 110}}));
  EXPECT_THAT(bound.canvas.areas, IsEmpty());
  const SeriesOnPaper data({line_series("", ColourRole::estimate, x, y)});
  const SeriesOnPaper one({line_series("", ColourRole::bound, {1}, {1})});
  EXPECT_THAT(data.canvas.lines, SizeIs(2));
  EXPECT_THAT(one.canvas.lines, SizeIs(1)) << "a short stroke alone would not be seen";
  for (const SeriesOnPaper* dots : {&data, &one}) {
    for (const RecordingCanvas::Line& dot : dots->canvas.lines) {
      EXPECT_EQ(dot.path.front().x, dot.path.back().x) << "a dot is a round end of no length";
    }
  }
  const SeriesOnPaper band({band_series("", ColourRole::estimate, x, y, {2, kNaN, 3})});
  EXPECT_THAT(band.outlines(), SizeIs(2));
}

TEST(SeriesPainter, PolygonsAreClosedAndFilledIfAsked) {
  Series corner = polygon_series("", ColourRole::estimate, {1, 3, 3}, {1, 1, 2});
  const CanvasPath closed{{110, 130}, {130, 130}, {130, 110}, {110, 130}};
  const SeriesOnPaper open({corner});
  EXPECT_THAT(open.canvas.lines_of(ColourRole::estimate), ElementsAre(closed));
  EXPECT_THAT(open.canvas.areas, IsEmpty());
  corner.filled = true;
  const SeriesOnPaper full({corner});
  EXPECT_THAT(full.canvas.lines_of(ColourRole::estimate), ElementsAre(closed));
  EXPECT_THAT(full.canvas.areas, SizeIs(1));
}

// Cells of width 2 and height 2 about (1, 3, 5) and 1: one area for the two equal ones, which reaches a unit
// to the right and above.
TEST(SeriesPainter, NeighboursOfOneColourAreOneArea) {
  const SeriesOnPaper paper({heat_series({1, 3, 5}, {1, 3}, (Matrix(2, 3) << 0, 0, 1, 0, 1, 1).finished())});
  ASSERT_THAT(paper.canvas.areas, SizeIs(4));
  EXPECT_EQ(paper.outlines()[0], (CanvasPath{{100, 109}, {141, 109}, {141, 150}, {100, 150}}));
  EXPECT_EQ(paper.outlines()[1], (CanvasPath{{140, 109}, {161, 109}, {161, 150}, {140, 150}}));
  EXPECT_EQ(paper.outlines()[3], (CanvasPath{{120, 69}, {161, 69}, {161, 110}, {120, 110}}));
  EXPECT_EQ(paper.canvas.areas[0].brush.rgb, sequential_colours().front());
  EXPECT_EQ(paper.canvas.areas[3].brush.rgb, sequential_colours().back());
}

TEST(SeriesPainter, TheLegendHasASampleOfEachKind) {
  const auto band = sample_of(band_series("", ColourRole::bound, {0}, {0}, {1}));
  ASSERT_THAT(band->areas, SizeIs(1));
  EXPECT_EQ(band->areas[0].outline, (CanvasPath{{20, 35}, {50, 35}, {50, 45}, {20, 45}}));
  const auto line = sample_of(step_series("", ColourRole::bound, {0}, {0}));
  EXPECT_THAT(line->lines_of(ColourRole::bound), ElementsAre(CanvasPath{{20, 40}, {50, 40}}));
  EXPECT_EQ(line->lines[0].pen.stroke, style_of(ColourRole::bound).stroke);
  const auto outline = sample_of(polygon_series("", ColourRole::bound, {0}, {0}));
  ASSERT_THAT(outline->lines_of(ColourRole::bound), SizeIs(1));
  EXPECT_EQ(outline->lines[0].path.front(), outline->lines[0].path.back()) << "a closed one";
  Series points = point_series("", ColourRole::bound, {0}, {0});
  points.marker = MarkerShape::dot;
  EXPECT_THAT(sample_of(points)->lines_of(ColourRole::bound), ElementsAre(CanvasPath{{35, 40}}));
  points.kind = SeriesKind::error_bars;
  EXPECT_THAT(sample_of(points)->lines, SizeIs(2)) << "a bar and its marker";
}

}  // namespace
}  // namespace credence::internal
