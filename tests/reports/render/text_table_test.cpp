#include "reports/render/text_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "reports/render/utf8_text.h"

namespace credence::internal {
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

TEST(TextTable, NoLineIsLongerThanTheWidthAndNoCellIsLost) {
  ReportTable table{"A title of several words that is too long for a narrow terminal",
                    {{"study", ColumnAlign::words}, {"runs"}, {"factor on P", ColumnAlign::words}},
                    {},
                    {"A note of several words that is too long for a narrow terminal, too."}};
  table.add({"figure1", 100, "1.02 (0.984 … 1.06)"});
  table.add({"planar", 5, {"1.26 (1.14 … 1.46)", CellTone::alarm}});
  for (const std::size_t width : {100U, 40U, 30U, 24U}) {
    const std::string text = text_table(table, false, width);
    std::string joined;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line); joined += line)
      EXPECT_LE(display_width(line), width) << text;
    for (const char* word : {"title", "figure1", "100", "(0.984", "1.06)", "planar", "1.46)", "note"}) {
      EXPECT_NE(joined.find(word), std::string::npos) << word << " at " << width << ":\n" << text;
    }
  }
  EXPECT_EQ(text_table(table, false, 30),
            "A title of several words that\n"
            "is too long for a narrow\n"
            "terminal\n"
            "\n"
            "study    runs  factor on P\n"
            "───────  ────  ───────────────\n"
            "figure1   100  1.02 (0.984 …\n"
            "               1.06)\n"
            "planar      5  1.26 (1.14 …\n"
            "               1.46)\n"
            "\n"
            "A note of several words that\n"
            "is too long for a narrow\n"
            "terminal, too.\n");
  EXPECT_EQ(text_table(table, false, 0), text_table(table)) << "one line a row where the width is not known";
}

TEST(TextTable, WhatDoesNotFitBesideEachOtherStandsBelow) {
  ReportTable table{"", {{"study", ColumnAlign::words}, {"verdict", ColumnAlign::words}, {"runs"}}, {}, {}};
  table.add({"figure1_two_landmarks", {"optimistic", CellTone::alarm}, 7});
  table.add({"b", "consistent", 12});
  EXPECT_EQ(text_table(table, true, 24),
            "figure1_two_landmarks\n"
            "  verdict  \x1b[1;31moptimistic\x1b[0m\n"
            "  runs     7\n"
            "\n"
            "b\n"
            "  verdict  consistent\n"
            "  runs     12\n");
}

TEST(TextTable, FirstCellsThatDoNotTellRowsApartHaveTheirTitle) {
  ReportTable table{
      "", {{"inflation", ColumnAlign::words}, {"scale"}, {"verdict", ColumnAlign::words}}, {}, {}};
  table.add({"map", 1, "consistent"});
  table.add({"map", 2, "pessimistic"});
  EXPECT_EQ(text_table(table, false, 24),
            "  inflation  map\n"
            "  scale      1\n"
            "  verdict    consistent\n"
            "\n"
            "  inflation  map\n"
            "  scale      2\n"
            "  verdict    pessimistic\n");
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
            "           –\n"
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

TEST(TextTable, OfATableWithoutColumnsTitleAndNotesStay) {
  EXPECT_EQ(text_table({"Answer", {}, {}, {"n = 0"}}), "Answer\n\nn = 0\n");
}

}  // namespace
}  // namespace credence::internal
