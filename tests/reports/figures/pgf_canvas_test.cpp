#include "reports/figures/pgf_canvas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using testing::HasSubstr;

TEST(PgfCanvas, DrawsUpFromTheLowerLeftCornerInBigPoints) {
  PgfCanvas canvas(378.0, 240.0, "two\nlines");
  const CanvasPath line{{0, 240}, {378, 0}};
  canvas.stroke({&line, 1}, {.rgb = 0xFF0000, .width = 1.5, .stroke = StrokeStyle::dashed});
  canvas.fill({&line, 1}, {0x0000FF, 0.25});
  canvas.write(figure_markup("K_{f1}"), {12, 228}, {.anchor = TextAnchor::end, .upright = true});
  const std::string pgf = std::move(canvas).finish();
  EXPECT_THAT(pgf, HasSubstr("\\pgfpathrectangle{\\pgfpointorigin}{\\pgfqpoint{252.000bp}{160.000bp}}"))
      << "3.5 in";
  EXPECT_THAT(pgf, HasSubstr("\\pgfpathmoveto{\\pgfqpoint{0.000bp}{0.000bp}}%\n"
                             "\\pgfpathlineto{\\pgfqpoint{252.000bp}{160.000bp}}"));
  EXPECT_THAT(pgf, HasSubstr("{rgb}{1.0000,0.0000,0.0000}"));
  EXPECT_THAT(pgf, HasSubstr("\\pgfsetfillopacity{0.250}"));
  EXPECT_THAT(pgf, HasSubstr("[right,base,x=8.000bp,y=8.000bp,rotate=90]"));
  EXPECT_THAT(pgf, HasSubstr("K\\textsubscript{f1}"));
  EXPECT_EQ(pgf.find("\nlines"), std::string::npos) << "a description stays in its comment";
  EXPECT_TRUE(pgf.ends_with("\\end{pgfpicture}%\n"));
}

}  // namespace
}  // namespace credence::internal
