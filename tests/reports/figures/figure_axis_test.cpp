#include "reports/figures/figure_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace credence::internal {
namespace {

using testing::ElementsAre;

std::vector<std::string> labels(const Axis& axis) {
  std::vector<std::string> texts;
  for (const AxisTick& tick : axis.ticks) texts.push_back(tick.label.text);
  return texts;
}

Panel panel_of(Series series) {
  Panel panel;
  panel.series = {std::move(series)};
  return panel;
}

/// 40 steps from one value, the first four of another.
Figure starting_figure(ColourRole role, double start, double rest) {
  FigureData y(40, rest);
  std::fill_n(y.begin(), 4, start);
  return {
      .name = "f",
      .caption = "C.",
      .panels = {{.series = {line_series("", role, index_axis(40), y),
                             line_series("", ColourRole::estimate, index_axis(40), FigureData(40, 0.0))}}}};
}

TEST(FigureAxis, WhatTheStartAloneNeedsIsLeftOut) {
  Figure much = starting_figure(ColourRole::estimate, 10.0, 1.0);
  leave_out_start(much, false);
  EXPECT_NEAR(much.panels[0].y_range.value().high, 1.05, 1e-12);
  EXPECT_EQ(much.caption, "C. What the first steps alone need lies beyond the axes.");
  Figure little = starting_figure(ColourRole::estimate, 1.9, 1.0);
  leave_out_start(little, false);
  EXPECT_FALSE(little.panels[0].y_range.has_value());
  EXPECT_EQ(little.caption, "C.");
  Figure data = starting_figure(ColourRole::estimate, 10.0, 1.0),
         bound = starting_figure(ColourRole::bound, 10.0, 1.0);
  leave_out_start(data, true);
  leave_out_start(bound, true);
  EXPECT_FALSE(data.panels[0].y_range.has_value()) << "what was measured stays";
  EXPECT_TRUE(bound.panels[0].y_range.has_value());
}

TEST(FigureAxis, TicksAreRoundAndShareTheirDecimals) {
  EXPECT_THAT(labels(make_axis({0, 100}, false, 5)), ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(labels(make_axis({-0.5, 1.02}, false, 3)), ElementsAre("−0.5", "0.0", "0.5", "1.0"));
  EXPECT_THAT(labels(make_axis({4512345, 4512395}, false, 3)), ElementsAre("4512360", "4512380"));
}

TEST(FigureAxis, BetweenWholeNumbersThereAreNoTicks) {
  EXPECT_THAT(labels(make_axis({1, 3}, false, 5)), ElementsAre("1.0", "1.5", "2.0", "2.5", "3.0"));
  EXPECT_THAT(labels(make_axis({1, 3}, false, 5, true)), ElementsAre("1", "2", "3"));
  EXPECT_THAT(labels(make_axis({0, 100}, false, 5, true)), ElementsAre("0", "20", "40", "60", "80", "100"));
  const auto whole = [](FigureData x) {
    const FigureData y(x.size(), 1.0);
    return has_whole_x(panel_of(line_series("", ColourRole::first, std::move(x), y)));
  };
  EXPECT_TRUE(whole({1, 2, 3}));
  EXPECT_TRUE(whole({1, std::numeric_limits<double>::quiet_NaN(), 3}));
  EXPECT_FALSE(whole({1, 2.5, 3}));
  EXPECT_FALSE(whole({}));
  EXPECT_FALSE(has_whole_x(panel_of(level_series("", ColourRole::first, 1.0))));
}

TEST(FigureAxis, ExtremeMagnitudesArePowers) {
  EXPECT_THAT(labels(make_axis({0, 2e-5}, false, 2)), ElementsAre("0", "1×10^{−5}", "2×10^{−5}"));
  EXPECT_THAT(labels(make_axis({-1.5e10, 0}, false, 3)),
              ElementsAre("−1.5×10^{10}", "−1.0×10^{10}", "−0.5×10^{10}", "0"));
}

TEST(FigureAxis, LogTicksAreDecadesOrOneTwoFive) {
  EXPECT_THAT(labels(make_axis({0.1, 10}, true, 7)), ElementsAre("0.1", "0.2", "0.5", "1", "2", "5", "10"));
  EXPECT_THAT(labels(make_axis({1e-6, 1e-1}, true, 5)),
              ElementsAre("10^{−6}", "10^{−5}", "10^{−4}", "10^{−3}", "10^{−2}", "10^{−1}"));
  EXPECT_LE(make_axis({1e-200, 1e200}, true, 5).ticks.size(), 7u);
  EXPECT_GE(make_axis({2, 3}, true, 4).ticks.size(), 2u) << "less than a decade needs labels too";
}

TEST(FigureAxis, AShortLogarithmicAxisHasThreeTicksAtLeast) {
  for (const auto& [low, high] :
       {std::pair{0.55, 1.9}, {0.21, 0.95}, {2.1, 9.0}, {0.3, 1.2}, {0.011, 0.049}}) {
    for (const int wanted : {3, 5, 8}) {
      EXPECT_GE(make_axis({low, high}, true, wanted).ticks.size(), 3U) << low << ' ' << high << ' ' << wanted;
    }
  }
}

TEST(FigureAxis, TicksStayWithinTheRange) {
  for (const auto& [low, high] : {std::pair{1.0, 100.0}, {-1e-9, 1e9}, {1e15, 1e15 + 4}, {-3e299, 3e299}}) {
    const Axis axis = make_axis({low, high}, false, 6);
    EXPECT_LE(axis.ticks.size(), 50u);
    for (const AxisTick& tick : axis.ticks) {
      EXPECT_GE(tick.value, low - 1e-8 * (high - low));
      EXPECT_LE(tick.value, high + 1e-8 * (high - low));
    }
  }
}

TEST(FigureAxis, RangesHoldTheDataAndIgnoreWhatIsNotFinite) {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  const Panel panel = panel_of(line_series("", ColourRole::first, {1, 2, 3}, {nan, -1, infinity}));
  EXPECT_EQ(x_range_of(panel).low, 1.0);
  EXPECT_EQ(x_range_of(panel).high, 3.0);
  EXPECT_LT(y_range_of(panel).low, -1.0);
  EXPECT_GT(y_range_of(panel).high, -1.0);
}

TEST(FigureAxis, BandsLevelsAndBarsCount) {
  const Panel band = panel_of(band_series("", ColourRole::bound, {1, 2}, {-5, -4}, {4, 6}));
  EXPECT_LE(y_range_of(band).low, -5.0);
  EXPECT_GE(y_range_of(band).high, 6.0);
  EXPECT_GE(y_range_of(panel_of(level_series("", ColourRole::bound, 7))).high, 7.0);
  EXPECT_GE(y_range_of(panel_of(error_bar_series("", ColourRole::first, {1}, {1}, {0}, {9}))).high, 9.0);
}

TEST(FigureAxis, NothingToShowStillGivesAnAxis) {
  const AxisRange range = y_range_of(panel_of(line_series("", ColourRole::first, {}, {})));
  EXPECT_LT(range.low, range.high);
  Panel log = panel_of(line_series("", ColourRole::first, {-1}, {0}));
  log.log_y = log.log_x = true;
  EXPECT_GT(y_range_of(log).low, 0.0);
  EXPECT_GT(x_range_of(log).low, 0.0);
}

TEST(FigureAxis, TheStatedRangeWins) {
  Panel panel = panel_of(line_series("", ColourRole::first, {1, 2}, {1, 1e9}));
  panel.y_range = AxisRange{0, 10};
  EXPECT_EQ(y_range_of(panel).high, 10.0);
}

TEST(FigureAxis, CellEdgesLieBetweenCentres) {
  EXPECT_THAT(cell_edges({1, 2, 4}, false), ElementsAre(0.5, 1.5, 3, 5));
  const auto log = cell_edges({1, 100}, true);
  EXPECT_NEAR(log[0], 0.1, 1e-12);
  EXPECT_NEAR(log[1], 10.0, 1e-10);
  EXPECT_NEAR(log[2], 1000.0, 1e-8);
  EXPECT_EQ(cell_edges({3}, false).size(), 2u);
}

TEST(FigureAxis, EqualiseGivesOneScale) {
  AxisRange x{0, 10};
  AxisRange y{0, 1};
  equalise(x, y, 2.0);
  EXPECT_DOUBLE_EQ(x.high - x.low, 10.0);
  EXPECT_DOUBLE_EQ(y.high - y.low, 5.0);
  EXPECT_DOUBLE_EQ(y.high + y.low, 1.0) << "grows about its middle";
}

}  // namespace
}  // namespace credence::internal
