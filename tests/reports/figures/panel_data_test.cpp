#include "reports/figures/panel_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/figures/figure_layout.h"

namespace credence::internal {
namespace {

nlohmann::json data_of(const Panel& panel) {
  const Figure figure{.name = "f", .panels = {panel}};
  const FigureLayout layout = lay_out(figure, 400.0);
  const std::string text = panel_data(figure.panels[0], layout.panels[0]);
  EXPECT_EQ(text.find_first_of("<&"), std::string::npos) << "it stands within an element of a page";
  return nlohmann::json::parse(text);
}

TEST(PanelData, HoldsNamedCurvesAndSharesTheirAbscissae) {
  Panel panel{.title = "a < b & c", .x_label = "step", .y_label = "error (m)"};
  const FigureData x = index_axis(5);
  panel.series = {
      line_series(figure_markup("K_{f1}"), ColourRole::estimate, x, {1.0, NAN, 3.0, 1.0 / 3.0, 5.0}),
      line_series("second", ColourRole::truth, x, {1, 2, 3, 4, 5}),
      line_series("", ColourRole::neutral, x, {0, 0, 0, 0, 0})};
  const auto data = data_of(panel);
  EXPECT_EQ(data["title"], "a < b & c");
  EXPECT_EQ(data["mode"], "column");
  ASSERT_EQ(data["series"].size(), 2U) << "what has no name is not told";
  EXPECT_EQ(data["series"][0]["n"], "K_f1");
  EXPECT_EQ(data["series"][0]["c"], "#0072b2");
  EXPECT_TRUE(data["series"][0]["y"][1].is_null());
  EXPECT_NEAR(data["series"][0]["y"][3].get<double>(), 1.0 / 3.0, 1e-5);
  ASSERT_EQ(data["columns"].size(), 1U);
  EXPECT_EQ(data["columns"][0], nlohmann::json({{"from", 1}, {"by", 1}, {"n", 5}}));
}

TEST(PanelData, AbscissaeWithGapsAreNotTakenForOthers) {
  Panel panel;
  panel.series = {line_series("a", ColourRole::first, {0, 1, 2}, {1, 2, 3}),
                  line_series("b", ColourRole::second, {NAN, 1, 2}, {1, 2, 3})};
  const auto data = data_of(panel);
  ASSERT_EQ(data["columns"].size(), 2U);
  EXPECT_EQ(data["columns"][0], nlohmann::json({0, 1, 2}));
  EXPECT_EQ(data["columns"][1], nlohmann::json({nullptr, 1, 2}));
  EXPECT_NE(data["series"][0]["x"], data["series"][1]["x"]);
}

TEST(PanelData, TwoLinesOfOneNameAreABand) {
  Panel panel;
  const FigureData x{0.0, 1.0, 4.0, 5.0};
  panel.series = {line_series("±2σ", ColourRole::bound, x, {-1, -2, -3, -4}),
                  line_series("", ColourRole::bound, x, {1, 2, 3, 4}),
                  line_series("error", ColourRole::estimate, x, {0, 0, 0, 0})};
  const auto data = data_of(panel);
  ASSERT_EQ(data["series"].size(), 2U);
  EXPECT_FALSE(data["series"][0].contains("y"));
  EXPECT_EQ(data["series"][0]["l"], nlohmann::json({-1, -2, -3, -4}));
  EXPECT_EQ(data["series"][0]["u"], nlohmann::json({1, 2, 3, 4}));
  EXPECT_EQ(data["columns"][0], nlohmann::json({0, 1, 4, 5})) << "not evenly spaced";
  EXPECT_EQ(data["parts"]["0"], nlohmann::json({0, 1})) << "both go when the entry is switched off";
}

TEST(PanelData, TheLineThroughErrorBarsBelongsToThem) {
  Panel panel;
  const FigureData x{1, 2}, y{3, 4};
  panel.series = {line_series("", ColourRole::first, x, y),
                  error_bar_series("measured", ColourRole::first, x, y, {2, 3}, {4, 5})};
  EXPECT_EQ(leading_series(panel), (std::vector<std::size_t>{1, 1}));
  const auto data = data_of(panel);
  ASSERT_EQ(data["series"].size(), 1U);
  EXPECT_EQ(data["series"][0]["u"], nlohmann::json({4, 5}));
  EXPECT_EQ(data["parts"]["1"], nlohmann::json({0, 1}));
}

TEST(PanelData, CurvesInThePlaneAreSearchedByDistance) {
  Panel panel;
  panel.series = {line_series("path", ColourRole::truth, {0, 1, 0}, {0, 1, 2})};
  EXPECT_EQ(data_of(panel)["mode"], "near") << "x goes back";
  panel.series = {line_series("path", ColourRole::truth, {0, 1, 2}, {0, 1, 2})};
  EXPECT_EQ(data_of(panel)["mode"], "column");
  panel.equal_aspect = true;
  EXPECT_EQ(data_of(panel)["mode"], "near");
}

TEST(PanelData, HeatMapsTellCellsEdgesAndNames) {
  Panel panel{.colour_label = "growth (m²)"};
  Matrix cells(2, 3);
  cells << 1, 2, 3, 4, NAN, 6;
  panel.series = {heat_series(index_axis(3), index_axis(2), cells)};
  panel.y_names = {"none", "map"};
  const auto data = data_of(panel);
  EXPECT_EQ(data["mode"], "cells");
  EXPECT_EQ(data["cells"]["v"][1][0], 4);
  EXPECT_TRUE(data["cells"]["v"][1][1].is_null());
  EXPECT_EQ(data["cells"]["xe"], nlohmann::json({0.5, 1.5, 2.5, 3.5}));
  EXPECT_EQ(data["cells"]["yn"][1], "map");
  EXPECT_EQ(data["valueLabel"], "growth (m²)");
}

TEST(PanelData, LongCurvesAreThinned) {
  Panel panel;
  const FigureData x = index_axis(100'000);
  panel.series = {line_series("long", ColourRole::first, x, FigureData(x.size(), 0.123456789))};
  const auto data = data_of(panel);
  const std::size_t kept = data["series"][0]["y"].size();
  EXPECT_LE(kept, 1500U);
  EXPECT_GT(kept, 1000U);
  EXPECT_EQ(data["columns"][0]["n"], kept) << "values and places agree";
}

}  // namespace
}  // namespace credence::internal
