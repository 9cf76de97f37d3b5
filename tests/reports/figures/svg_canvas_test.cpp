#include "reports/figures/svg_canvas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/reports/render/markup_check.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

template <class Draw>
std::string svg_of(Draw draw) {
  SvgCanvas canvas(100.0, 50.5, "a < b");
  draw(canvas);
  std::string svg = std::move(canvas).finish();
  EXPECT_EQ(xml_problem(svg), "");
  return svg;
}

std::string path_of(const CanvasPath& path) {
  const std::string svg = svg_of([&](Canvas& canvas) { canvas.stroke({&path, 1}, {}); });
  const std::size_t start = svg.find(" d=\"") + 4;
  return svg.substr(start, svg.find('"', start) - start);
}

TEST(SvgCanvas, IsOneElementThatScalesAndHasADescription) {
  const std::string svg = svg_of([](Canvas&) {});
  EXPECT_TRUE(
      svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 50.5\" width=\"100\""));
  EXPECT_THAT(svg, HasSubstr("role=\"img\" aria-label=\"a &lt; b\""));
  EXPECT_THAT(svg, HasSubstr("sans-serif"));
}

TEST(SvgCanvas, PathsAreStepsOfTwoDecimals) {
  EXPECT_EQ(path_of({{1.234, 5}, {2.234, 5}, {2.234, 4.5}, {3, 4.25}, {4.5, 3}}),
            "M1.23 5h1v-.5l.77-.25 1.5-1.25");
  EXPECT_EQ(path_of({{-0.001, 0.0}, {10.0, 0.0}}), "M0 0h10") << "no negative zero";
}

TEST(SvgCanvas, RoundingDoesNotAddUp) {
  CanvasPath path{{0.0, 0.0}};
  for (int i = 1; i <= 1000; ++i) path.push_back({0.0, 0.014 * i});
  const std::string data = path_of(path);
  double y = 0.0;
  for (std::size_t i = data.find('v') + 1; i < data.size();) {
    std::size_t used = 0;
    y += std::stod(data.substr(i), &used);
    i += used;
  }
  EXPECT_NEAR(y, 14.0, 0.0051);
}

TEST(SvgCanvas, PointsThatCoincideAreOne) { EXPECT_EQ(path_of({{1, 1}, {1.001, 1}, {2, 1}}), "M1 1h1"); }

TEST(SvgCanvas, ManyPathsAreOneElement) {
  const std::vector<CanvasPath> dots{{{1, 2}}, {{3, 4}}};
  const std::string svg =
      svg_of([&](Canvas& canvas) { canvas.stroke(dots, {.rgb = 0xFF0010, .width = 3.0, .dots = true}); });
  EXPECT_THAT(svg,
              HasSubstr("<path fill=\"none\" stroke=\"#ff0010\" stroke-width=\"3\" stroke-linecap=\"round\" "
                        "d=\"M1 2h0M3 4h0\"/>"));
}

TEST(SvgCanvas, DashesFollowTheWidth) {
  const CanvasPath line{{0, 0}, {9, 0}};
  const std::string dashed = svg_of([&](Canvas& canvas) {
    canvas.stroke({&line, 1}, {.width = 2.0, .stroke = StrokeStyle::dashed});
  });
  EXPECT_THAT(dashed, HasSubstr("stroke-dasharray=\"6 3.5\""));
  EXPECT_THAT(svg_of([&](Canvas& canvas) { canvas.stroke({&line, 1}, {}); }), Not(HasSubstr("dasharray")));
}

TEST(SvgCanvas, AreasAreClosedAndMayShine) {
  const CanvasPath triangle{{0, 0}, {4, 0}, {4, 3}};
  const std::string svg = svg_of([&](Canvas& canvas) {
    canvas.fill({&triangle, 1}, {0x0072B2, 0.15});
    canvas.fill({&triangle, 1}, {0x000000, 1.0});
  });
  EXPECT_THAT(svg, HasSubstr("<path fill=\"#0072b2\" fill-opacity=\".15\" d=\"M0 0h4v3z\"/>"));
  EXPECT_THAT(svg, HasSubstr("<path fill=\"#000000\" d=\"M0 0h4v3z\"/>"));
}

TEST(SvgCanvas, WordsStayWords) {
  const std::string svg = svg_of([](Canvas& canvas) {
    canvas.write("error (m²) <b>&", {10, 20.5}, {.anchor = TextAnchor::middle, .bold = true});
    canvas.write("up", {5, 6}, {.anchor = TextAnchor::end, .rgb = 0xD55E00, .upright = true});
  });
  EXPECT_THAT(svg,
              HasSubstr("<text x=\"10\" y=\"20.5\" text-anchor=\"middle\" font-weight=\"bold\">error (m²) "
                        "&lt;b&gt;&amp;</text>"));
  EXPECT_THAT(svg, HasSubstr("<text transform=\"translate(5 6)rotate(-90)\" text-anchor=\"end\" "
                             "fill=\"#d55e00\">up</text>"));
}

TEST(SvgCanvas, ScriptsAreSmallAndTheBaseLineComesBack) {
  const std::string svg = svg_of([](Canvas& canvas) {
    canvas.write(figure_markup("10^{−2} m"), {0, 0}, {});
  });
  EXPECT_THAT(
      svg, HasSubstr(">10<tspan dy=\"-4.5\" font-size=\"9\">−2</tspan><tspan dy=\"4.5\"> m</tspan></text>"));
  const std::string both = svg_of([](Canvas& canvas) {
    canvas.write(figure_markup("K_{f}^{2}"), {0, 0}, {});
  });
  EXPECT_THAT(
      both,
      HasSubstr("<tspan dy=\"2.5\" font-size=\"9\">f</tspan><tspan dy=\"-7\" font-size=\"9\">2</tspan>"));
}

}  // namespace
}  // namespace credence::internal
