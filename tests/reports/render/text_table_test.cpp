#include "reports/render/text_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace credence {
namespace {

ReportTable small_table() {
  ReportTable table{
      "Verdicts", {{"case", ColumnAlign::words}, {"σ²"}, {"verdict", ColumnAlign::words}}, {}, {}};
  table.add({"σ² × 2", 2.5, {"optimistic", CellTone::alarm}});
  table.add({"plain", 12, {"consistent", CellTone::good}});
  return table;
}

TEST(TextTable, AlignsByColumnsAndDecimalPoints) {
  EXPECT_EQ(text_table(small_table()),
            "Verdicts\n"
            "\n"
            "case        σ²  verdict\n"
            "──────  ──────  ──────────\n"
            "σ² × 2   2.500  optimistic\n"
            "plain   12      consistent\n");
}

TEST(TextTable, ColoursOnlyOnRequest) {
  EXPECT_EQ(text_table(small_table()).find('\x1b'), std::string::npos);
  EXPECT_NE(text_table(small_table(), true).find("\x1b[1;31moptimistic\x1b[0m"), std::string::npos);
}

TEST(TextTable, EscapesOfNamesDoNotReachTheTerminal) {
  ReportTable table{"a\x1b[2Jb", {{"x\n", ColumnAlign::words}}, {}, {"note\x07"}};
  table.add({"\x1b]0;title\x07\r"});
  for (const char c : text_table(table)) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
}

TEST(TextTable, ShowsWhatIsNoNumber) {
  ReportTable table{"", {{"value"}}, {}, {}};
  table.add({std::nan("")});
  table.add({"not measured"});
  table.add({1e-12});
  table.add({-3});
  table.add({0.25});
  EXPECT_EQ(text_table(table),
            "       value\n"
            "────────────\n"
            "         nan\n"
            "not measured\n"
            "   1.000e−12\n"
            "     −3\n"
            "      0.2500\n");
}

TEST(TextTable, ARowOfAnotherLengthIsAnError) {
  ReportTable table = small_table();
  EXPECT_THROW(table.add({"only one"}), std::invalid_argument);
}

TEST(TextTable, AnEmptyTableHasAHeader) {
  EXPECT_EQ(text_table({"", {{"a", ColumnAlign::words}}, {}, {"n = 0"}}), "a\n─\n\nn = 0\n");
}

}  // namespace
}  // namespace credence
