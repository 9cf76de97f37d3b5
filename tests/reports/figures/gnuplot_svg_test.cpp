#include "reports/figures/gnuplot_svg.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "reports/figures/gnuplot_svg_tag.h"
#include "reports/render/html_text.h"
#include "tests/reports/render/markup_check.h"

namespace credence {
namespace {

std::string wrapped(const std::string& inside) {
  return "<?xml version=\"1.0\"?>\n<svg \n viewBox=\"0 0 100 50\" width='1'>\n<title>t</title>" + inside +
         "</svg>\n";
}

TEST(SvgCleaner, KeepsDrawingAndDropsIds) {
  const std::string svg = clean_svg(
      wrapped("<g id=\"plot_1\"><title>x</title>\n<path stroke='rgb(255,   0,  16)' stroke-dasharray='4,2' "
              "d='M1.06,2.04 L-0.01,3.00  '/></g>"),
      "a < b");
  EXPECT_EQ(xml_problem(svg), "");
  EXPECT_EQ(svg.find("id="), std::string::npos);
  EXPECT_NE(svg.find("viewBox=\"0 0 100 50\""), std::string::npos);
  EXPECT_NE(svg.find("aria-label=\"a &lt; b\""), std::string::npos);
  EXPECT_NE(svg.find("<path stroke=\"#ff0010\" stroke-dasharray=\"4,2\" d=\"M1.1,2 L0,3\"/>"),
            std::string::npos);
}

TEST(SvgCleaner, JoinsEqualMarkers) {
  const std::string use = "<use xlink:href='#gpPt6' transform='translate(3,4) scale(2)' color='black'/>";
  const std::string other = "<use xlink:href='#gpPt0' transform='translate(3,4) scale(2)' color='black'/>";
  const std::string svg = clean_svg(wrapped("<g>" + use + use + other + "</g>"), "");
  EXPECT_EQ(count_of(svg, "<path"), 2);
  EXPECT_NE(svg.find("d=\"M3 4h0M3 4h0\""), std::string::npos);
  EXPECT_NE(svg.find("d=\"M1 4h4M3 2v4\""), std::string::npos);
}

TEST(SvgCleaner, BringsSpecialCharactersBackAsEntities) {
  // U+E000 + '<' and + '&' as gnuplot_string sends them.
  const std::string svg =
      clean_svg(wrapped("<g><text><tspan font-family=\"x\" >\uE03C\uE026</tspan></text></g>"), "");
  EXPECT_NE(svg.find("<text>&lt;&amp;</text>"), std::string::npos);
}

TEST(SvgCleaner, RefusesWhatIsNoDrawing) {
  for (const char* inside :
       {"<script>alert(1)</script>", "<a href='x'/>", "<foreignObject/>", "<image/>", "</g>", "</tspan>",
        "<use xlink:href='#evil' transform='translate(1,1) scale(1)'/>", "<use/>", "<rect fill='red'/>",
        "<path d='M--1'/>"}) {
    EXPECT_THROW(clean_svg(wrapped(inside), ""), std::runtime_error) << inside;
  }
}

TEST(SvgCleaner, RefusesWhatIsNotComplete) {
  for (const char* raw : {"", "text", "<svg viewBox='0 0 1 1'>", "<svg viewBox='0 0 1 1'><g", "<svg"}) {
    EXPECT_THROW(clean_svg(raw, ""), std::runtime_error) << raw;
  }
}

TEST(SvgTag, ReadsNamesAndAttributes) {
  const SvgTag tag = parse_svg_tag("polygon fill = 'rgb(1, 2, 3)'\n points='1,2 '/");
  EXPECT_EQ(tag.name, "polygon");
  EXPECT_EQ(tag.value("fill"), "rgb(1, 2, 3)");
  EXPECT_EQ(tag.value("points"), "1,2 ");
  EXPECT_EQ(tag.value("missing"), "");
  EXPECT_TRUE(parse_svg_tag("/g").closes);
}

TEST(SvgTag, ShortensColours) {
  EXPECT_EQ(short_colour("rgb( 86, 180, 233)"), "#56b4e9");
  EXPECT_EQ(short_colour("black"), "black");
  EXPECT_EQ(short_colour("rgb(1"), "#01");
}

TEST(EscapeHtml, LeavesNothingThatActs) {
  EXPECT_EQ(escape_html("<a href=\"x\" o='y'>&\n\x01"), "&lt;a href=&quot;x&quot; o=&#39;y&#39;&gt;&amp;  ");
  EXPECT_EQ(escape_html("σ² ≤ 1"), "σ² ≤ 1");
}

}  // namespace
}  // namespace credence
