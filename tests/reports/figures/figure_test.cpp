#include "reports/figures/figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/nan.h"

namespace credence::internal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Figure figure_of(Series series) {
  Panel panel;
  panel.title = "errors";
  panel.series = {std::move(series)};
  Figure figure;
  figure.name = "test";
  figure.panels = {panel};
  return figure;
}

std::string problem_of(const Figure& figure) {
  try {
    validate(figure);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(FigureData, TakesWhatResultsAreMadeOf) {
  Matrix matrix(2, 3);
  matrix << 1, 2, 3, 4, 5, 6;
  const Vector vector = Vector::LinSpaced(3, 0.0, 1.0);
  EXPECT_THAT(FigureData(matrix.row(1)), ElementsAre(4, 5, 6));
  EXPECT_THAT(FigureData(matrix.col(1)), ElementsAre(2, 5));
  EXPECT_THAT(FigureData(2.0 * vector), ElementsAre(0, 1, 2));
  EXPECT_THAT(FigureData(vector.array().square() + 1.0), ElementsAre(1, 1.25, 2));
  EXPECT_THAT(FigureData(std::vector<double>{7, 8}), ElementsAre(7, 8));
  EXPECT_THAT(index_axis(3), ElementsAre(1, 2, 3));
  EXPECT_TRUE(FigureData(Vector()).empty());
}

TEST(Figure, AcceptsEverySeries) {
  const FigureData x{1, 2, kNaN};
  for (const Series& series :
       {line_series("l", ColourRole::truth, x, x), step_series("s", ColourRole::estimate, x, x),
        point_series("p", ColourRole::measurement, x, x), band_series("b", ColourRole::bound, x, x, x),
        level_series("h", ColourRole::neutral, 1), upright_series("v", ColourRole::neutral, 1),
        error_bar_series("e", ColourRole::exact, x, x, x, x), polygon_series("o", ColourRole::alarm, x, x),
        text_series(ColourRole::first, x, x, {"a", "b", "c"}),
        heat_series({1, 2}, {1, 2, 3}, Matrix::Zero(3, 2))}) {
    EXPECT_EQ(problem_of(figure_of(series)), "");
  }
}

TEST(Figure, NamesTheSeriesThatDoesNotFit) {
  EXPECT_THAT(problem_of(figure_of(line_series("mean", ColourRole::estimate, {1, 2}, {1}))),
              AllOf(HasSubstr("figure 'test'"), HasSubstr("panel 1 'errors'"), HasSubstr("series 1 'mean'"),
                    HasSubstr("2 values of x, 1 of y")));
  EXPECT_NE(problem_of(figure_of(band_series("", ColourRole::bound, {1, 2}, {1}, {1, 2}))), "");
  EXPECT_NE(problem_of(figure_of(error_bar_series("", ColourRole::first, {1}, {1}, {1}, {}))), "");
  EXPECT_NE(problem_of(figure_of(text_series(ColourRole::first, {1}, {1}, {}))), "");
  EXPECT_NE(problem_of(figure_of(heat_series({1, 2}, {1}, Matrix::Zero(2, 1)))), "");
  EXPECT_NE(problem_of(figure_of(heat_series({2, 1}, {1}, Matrix::Zero(1, 2)))), "");
  Series heavy = level_series("", ColourRole::bound, 1.0);
  heavy.weight = kNaN;
  EXPECT_NE(problem_of(figure_of(heavy)), "");
}

TEST(Figure, RefusesImpossibleRangesGridsAndNames) {
  const Figure good = figure_of(level_series("", ColourRole::bound, 1.0));
  ASSERT_EQ(problem_of(good), "");
  Figure bad = good;
  bad.panels[0].y_range = AxisRange{2.0, 1.0};
  EXPECT_THAT(problem_of(bad), HasSubstr("y range [2, 1]"));
  bad.panels[0].y_range = AxisRange{0.0, 1.0};
  bad.panels[0].log_y = true;
  EXPECT_THAT(problem_of(bad), HasSubstr("positive"));
  bad = good;
  bad.panels[0].log_x = bad.panels[0].equal_aspect = true;
  EXPECT_THAT(problem_of(bad), HasSubstr("equal aspect"));
  bad = good;
  bad.panels.push_back(bad.panels[0]);
  EXPECT_THAT(problem_of(bad), HasSubstr("2 panels for a grid of 1x1"));
  bad = good;
  bad.rows = 0;
  EXPECT_THAT(problem_of(bad), HasSubstr("grid of 0x1"));
  for (const char* name : {"", "../up", "a b", "a\"b", "ä"}) {
    bad = good;
    bad.name = name;
    EXPECT_THAT(problem_of(bad), HasSubstr("name")) << name;
  }
}

TEST(Figure, ManyPanelsWrapAndOfTooManyTheFirstStay) {
  const auto arranged = [](std::size_t panels, int columns) {
    Figure figure = figure_of(level_series("", ColourRole::bound, 1.0));
    figure.panels.resize(panels, figure.panels[0]);
    arrange(figure, columns);
    EXPECT_EQ(problem_of(figure), "") << panels;
    return figure;
  };
  EXPECT_EQ(arranged(4, 3).cols, 2);
  EXPECT_EQ(arranged(9, 3).cols, 3);
  EXPECT_EQ(arranged(9, 3).rows, 3);
  EXPECT_EQ(arranged(9, 2).rows, 5);
  EXPECT_EQ(arranged(kMostPanels, 1).caption, "");
  const Figure many = arranged(kMostPanels + 2, 3);
  EXPECT_EQ(many.panels.size(), kMostPanels);
  EXPECT_EQ(many.caption, " Of 42 panels the first 40 are shown.");
}

TEST(Figure, HasDataWhereSomethingButALevelCanBeDrawn) {
  const auto drawn = [](const Series& series, bool log_y = false) {
    Figure figure = figure_of(series);
    figure.panels[0].log_y = log_y;
    EXPECT_EQ(has_data(figure), has_data(figure.panels[0]));
    return has_data(figure);
  };
  const FigureData x{1, 2}, y{kNaN, 3}, none{kNaN, kNaN};
  EXPECT_TRUE(drawn(line_series("", ColourRole::first, x, y)));
  EXPECT_FALSE(drawn(line_series("", ColourRole::first, x, none)));
  EXPECT_FALSE(drawn(line_series("", ColourRole::first, {kNaN, kNaN}, {1, 2})));
  EXPECT_FALSE(drawn(line_series("", ColourRole::first, {1, kNaN}, y))) << "no point has both";
  EXPECT_TRUE(drawn(point_series("", ColourRole::first, x, {-1, 0})));
  EXPECT_FALSE(drawn(point_series("", ColourRole::first, x, {-1, 0}), true)) << "a logarithmic axis";
  EXPECT_TRUE(drawn(band_series("", ColourRole::first, x, y, y)));
  EXPECT_FALSE(drawn(band_series("", ColourRole::first, x, y, none)));
  EXPECT_TRUE(drawn(error_bar_series("", ColourRole::first, x, y, none, none))) << "its marker";
  EXPECT_TRUE(drawn(heat_series({1}, {1, 2}, Matrix{{kNaN}, {1.0}})));
  EXPECT_FALSE(drawn(heat_series({1}, {1, 2}, Matrix::Constant(2, 1, kNaN))));
  EXPECT_FALSE(drawn(level_series("", ColourRole::first, 1.0)));
  EXPECT_FALSE(drawn(upright_series("", ColourRole::first, 1.0)));
  const Panel panel;
  EXPECT_TRUE(has_data(panel, level_series("", ColourRole::first, 1.0)));
  EXPECT_FALSE(has_data(panel, level_series("", ColourRole::first, kNaN)));
  EXPECT_FALSE(has_data(Figure{}));
}

// Points of the ellipse satisfy (p - m)ᵀ C⁻¹ (p - m) = k².
TEST(Ellipse, LiesAtKSigma) {
  Eigen::Matrix2d covariance;
  covariance << 2.0, 0.6, 0.6, 0.5;
  const Eigen::Vector2d mean(3.0, -1.0);
  const PlanarCurve curve = ellipse_points(mean, covariance, 2.0, 60);
  ASSERT_EQ(curve.x.size(), 60u);
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    const Eigen::Vector2d d = Eigen::Vector2d(curve.x[i], curve.y[i]) - mean;
    EXPECT_NEAR(d.dot(covariance.inverse() * d), 4.0, 1e-10);
  }
  EXPECT_NEAR(*std::max_element(curve.x.begin(), curve.x.end()), 3.0 + 2.0 * std::sqrt(2.0), 0.02);
}

TEST(Ellipse, SingularCovariancesAreLegalAndIndefiniteOnesAreNot) {
  const Eigen::Vector2d mean(1.0, 2.0);
  Eigen::Matrix2d line;
  line << 1.0, 2.0, 2.0, 4.0;
  const PlanarCurve segment = ellipse_points(mean, line, 1.0);
  ASSERT_FALSE(segment.x.empty());
  for (std::size_t i = 0; i < segment.x.size(); ++i)
    EXPECT_NEAR(segment.y[i] - 2.0, 2.0 * (segment.x[i] - 1.0), 1e-7);
  EXPECT_FALSE(ellipse_points(mean, Eigen::Matrix2d::Zero(), 1.0).x.empty());
  EXPECT_TRUE(ellipse_points(mean, -Eigen::Matrix2d::Identity(), 1.0).x.empty());
  EXPECT_TRUE(ellipse_points(mean, Eigen::Vector2d(1.0, -0.1).asDiagonal().toDenseMatrix(), 1.0).x.empty());
  EXPECT_TRUE(ellipse_points(mean, Eigen::Matrix2d::Constant(kNaN), 1.0).x.empty());
}

TEST(Ellipse, ManyShareASeries) {
  PlanarCurve all;
  append_curve(all, {});
  append_curve(all, {{1, 2}, {3, 4}});
  append_curve(all, {});
  append_curve(all, {{5}, {6}});
  ASSERT_EQ(all.x.size(), 4u);
  EXPECT_TRUE(std::isnan(all.x[2]) && std::isnan(all.y[2]));
  EXPECT_EQ(all.y[3], 6.0);
}

TEST(FigureStyle, RolesThatShareAPanelDiffer) {
  const std::vector<ColourRole> together{ColourRole::truth,       ColourRole::estimate, ColourRole::bound,
                                         ColourRole::measurement, ColourRole::exact,    ColourRole::alarm,
                                         ColourRole::neutral};
  for (const ColourRole a : together) {
    for (const ColourRole b : together) {
      EXPECT_EQ(a == b, style_of(a).rgb == style_of(b).rgb);
    }
  }
  EXPECT_EQ(numbered_role(0), ColourRole::first);
  EXPECT_EQ(numbered_role(7), ColourRole::second);
}

}  // namespace
}  // namespace credence::internal
