#include "reports/figures/figure_text.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

// "words" for the base line, "_words" and "^words" for subscripts and superscripts.
std::vector<std::string> shown(const FigureText& text) {
  std::vector<std::string> all;
  for (const TextRun& run : text_runs(text)) {
    const char* mark = run.level == TextLevel::subscript     ? "_"
                       : run.level == TextLevel::superscript ? "^"
                                                             : "";
    all.push_back(mark + run.words);
  }
  return all;
}

using Runs = std::vector<std::string>;

TEST(FigureText, MarkupActsOnlyWhereItIsAskedFor) {
  EXPECT_EQ(shown("K_{f1} {x}"), Runs{"K_{f1} {x}"});
  EXPECT_EQ(shown(figure_markup("K_{f1}^{2} m")), (Runs{"K", "_f1", "^2", " m"}));
  EXPECT_EQ(shown(figure_markup("_{f}")), Runs{"_f"});
}

TEST(FigureText, MarksWithoutAnEndAreLiteral) {
  EXPECT_EQ(shown(figure_markup("a_b^c{d}_{e")), Runs{"a_b^c{d}_{e"});
  EXPECT_EQ(shown(figure_markup("x_")), Runs{"x_"});
  EXPECT_EQ(shown(figure_markup("")), Runs{""});
}

TEST(FigureText, IsOnePrintableLine) {
  EXPECT_EQ(shown("a\nb\x1b\xff"), Runs{"a b \uFFFD"});
  EXPECT_EQ(shown(figure_markup("a_{\n}")), (Runs{"a", "_ "}));
}

TEST(FigureText, WidthIsThatOfTheWidestUsualFont) {
  // DejaVu Sans of 12 units, as cairo measures it.
  EXPECT_NEAR(text_width("measured mean"), 98.05, 3.0);
  EXPECT_NEAR(text_width("0123456789"), 76.30, 1.0);
  EXPECT_GT(text_width("W"), 2.5 * text_width("i"));
  EXPECT_EQ(text_width(""), 0.0);
  EXPECT_GT(text_width("結果"), 1.9 * text_width("結") - 1e-9);
  EXPECT_EQ(text_width("e\u0301"), text_width("e")) << "an accent stands above its letter";
}

TEST(FigureText, MarksTakeNoRoomAndScriptsLittle) {
  EXPECT_LT(text_width(figure_markup("K_{f1}")), text_width("Kf1"));
  EXPECT_GT(text_width(figure_markup("K_{f1}")), text_width("Kf"));
  EXPECT_DOUBLE_EQ(text_width("K_{f1}"), text_width("K") + text_width("_{f1}"));
}

}  // namespace
}  // namespace credence::internal
