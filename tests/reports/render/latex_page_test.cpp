#include "reports/render/latex_page.h"

#include <gmock/gmock.h>

namespace credence::internal {
namespace {

TEST(LatexPage, TablesAreTabularsAndSentencesComments) {
  ReportTable table{"Runs & steps", {{"what", ColumnAlign::words}, {"mean"}}, {}, {"Of 5 % of all."}};
  table.add({"NEES", 2.5});
  Document document("Study");
  document.answer = {CellTone::good, "All is well"};
  document.show_answer();
  document.brief.emplace_back(table);
  EXPECT_EQ(latex_page(document),
            "% \\usepackage{booktabs}\n"
            "% All is well.\n"
            "\\begin{table}\n"
            "  \\centering\n"
            "  \\caption{Runs \\& steps}\n"
            "  \\begin{tabular}{lr}\n"
            "    \\toprule\n"
            "    what & mean \\\\\n"
            "    \\midrule\n"
            "    NEES & 2.500 \\\\\n"
            "    \\bottomrule\n"
            "  \\end{tabular}\n"
            "\\end{table}\n"
            "% Of 5 % of all.\n");
}

TEST(LatexPage, OfATableWithoutColumnsTheNotesStay) {
  Document document("Study");
  document.brief.emplace_back(ReportTable{"Answer", {}, {}, {"n = 0"}});
  EXPECT_EQ(latex_page(document), "% \\usepackage{booktabs}\n% n = 0\n");
}

TEST(LatexPage, ATableKeepsItsColumnsWhereTheFirstHasNoTitle) {
  ReportTable table{"Noise", {{"", ColumnAlign::words}, {"present"}, {"tuned"}}, {}, {}};
  table.add({"", 1, 2});
  Document document("Noise");
  document.brief.emplace_back(table);
  const std::string text = latex_page(document);
  EXPECT_THAT(text, testing::HasSubstr("     & present & tuned \\\\"));
  EXPECT_THAT(text, testing::HasSubstr("     & 1 & 2 \\\\"));
}

TEST(LatexPage, WhatLatexWouldTakeForACommandIsEscaped) {
  EXPECT_EQ(escape_latex("a_b 5 % $x$ {\\#}"), "a\\_b 5 \\% \\$x\\$ \\{\\textbackslash{}\\#\\}");
  EXPECT_EQ(escape_latex("1.02 (0.98 … 1.06)"), "1.02 (0.98 \\dots{} 1.06)");
  EXPECT_EQ(escape_latex("two\nlines"), "two lines");
}

TEST(LatexPage, LettersOfFormulasAreMathematics) {
  EXPECT_EQ(escape_latex("rank ΔP ≤ rank O, gap ∞"), "rank $\\Delta$P $\\le$ rank O, gap $\\infty$");
  for (const char* letters : {"≥ ≫ · ‖ ▲ ▼", "³ ⁺ ² ⁻¹ ᵀ", "x̂ α θ π Σ χ σ ν Φ µ √", "− – — … × ± ° “ ”"}) {
    for (const char c : escape_latex(letters)) EXPECT_GE(c, 0) << letters;
  }
}

TEST(LatexPage, NumbersHavePowersOfTen) {
  EXPECT_EQ(escape_latex("8.18e−5"), "8.18$\\times10^{-5}$");
  EXPECT_EQ(escape_latex("< 1e−12"), "$<$ 1$\\times10^{-12}$");
  EXPECT_EQ(escape_latex("2.7e6"), "2.7$\\times10^{6}$");
  EXPECT_EQ(escape_latex("−0.5"), "$-$0.5");
  EXPECT_EQ(escape_latex("step 2e, x1end"), "step 2e, x1end");
}

}  // namespace
}  // namespace credence::internal
