#include "reports/document/report_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

ReportTable column_of(const std::vector<TableCell>& cells) {
  ReportTable table{"t", {{"value"}}, {}, {}};
  for (const TableCell& cell : cells) table.add({cell});
  return table;
}

TEST(ReportTable, DecimalPointsStandBelowEachOther) {
  // Right aligned: the same number of characters stands behind every point.
  const auto aligned = align_decimals(column_of({"1.25", "10", "−0.5", "+3.125"}), 0, "_", ".");
  EXPECT_THAT(aligned, ElementsAre("1.25_", "10.___", "−0.5__", "+3.125"));
}

TEST(ReportTable, WholeNumbersAloneGetNoPoint) {
  EXPECT_THAT(align_decimals(column_of({"7", "12"}), 0, "_", "."), ElementsAre("7", "12"));
}

TEST(ReportTable, WordsIntervalsAndExponentsAreLeftAlone) {
  EXPECT_THAT(align_decimals(column_of({"1.5", "–", "1.2 … 1.6", "3 of 4", "1.25e-7", ""}), 0, "_", "."),
              ElementsAre("1.5", "–", "1.2 … 1.6", "3 of 4", "1.25e-7", ""));
  // An exponent with many digits makes no room.
  EXPECT_THAT(align_decimals(column_of({"1.123456e5", "2.5"}), 0, "_", "."),
              ElementsAre("1.123456e5", "2.5"));
}

TEST(ReportTable, IntegersHaveTheMinusOfTheirNeighbours) {
  EXPECT_EQ(TableCell(-12).text, "−12");
  EXPECT_EQ(TableCell(std::int64_t{0}).text, "0");
  EXPECT_EQ(TableCell(std::numeric_limits<std::int64_t>::min()).text, "−9223372036854775808");
  EXPECT_EQ(TableCell(std::numeric_limits<std::uint64_t>::max()).text, "18446744073709551615");
}

TEST(ReportTable, ARowHasACellForEachColumn) {
  ReportTable table{"a title", {{"one"}, {"two"}}, {}, {}};
  EXPECT_THAT([&] { table.add({"only"}); }, ThrowsMessage<std::invalid_argument>(
                                                HasSubstr("table 'a title': row of 1 cells for 2 columns")));
  EXPECT_TRUE(table.rows.empty());
}

TEST(ReportTable, AColumnIsTakenOutOfEveryRow) {
  ReportTable table{.columns = {{"a"}, {"b"}, {"c"}}};
  table.add({1, 2, 3});
  table.remove_column(1);
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[1].title, "c");
  ASSERT_EQ(table.rows[0].size(), 2U);
  EXPECT_EQ(table.rows[0][0].text, "1");
  EXPECT_EQ(table.rows[0][1].text, "3");
}

TEST(ReportTable, ForeignTextIsOneLine) {
  const auto texts = align_decimals(column_of({"two\nlines\x1b[31m"}), 0, "_", ".");
  EXPECT_EQ(texts[0].find_first_of("\n\x1b"), std::string::npos);
}

}  // namespace
}  // namespace credence::internal
