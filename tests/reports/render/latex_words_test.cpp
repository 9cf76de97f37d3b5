#include "reports/render/latex_words.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(LatexWords, WhatLatexReadsAsCommandsIsEscaped) {
  EXPECT_EQ(latex_words("100 % of P_{f1} & #3"), "100 \\% of P\\_\\{f1\\} \\& \\#3");
  EXPECT_EQ(latex_words("\\input{x}"), "\\textbackslash{}input\\{x\\}");
  EXPECT_EQ(latex_words("a|b"), "a$|$b");
}

TEST(LatexWords, SignsThatTextLacksAreMathematics) {
  EXPECT_EQ(latex_words("±2σ (m²)"), "$\\pm$2$\\sigma$ (m\\textsuperscript{2})");
  EXPECT_EQ(latex_words("ω → x̂ S⁻¹ s⁻"),
            "$\\omega$ $\\rightarrow$ $\\hat{x}$ S\\textsuperscript{$-$1} s\\textsuperscript{$-$}");
  EXPECT_EQ(latex_words("café"), "café") << "letters of UTF-8 are known to LaTeX";
}

TEST(LatexWords, AreTakenFromTheFront) {
  std::string_view text = "σb";
  EXPECT_EQ(take_latex(text), "$\\sigma$");
  EXPECT_EQ(take_latex(text), "b");
  EXPECT_TRUE(text.empty());
}

}  // namespace
}  // namespace credence::internal
