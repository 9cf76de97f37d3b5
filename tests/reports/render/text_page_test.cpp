#include "reports/render/text_page.h"

#include <gtest/gtest.h>

#include "reports/render/text_table.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

ReportTable table_titled(const std::string& title) {
  ReportTable table{title, {{"case", ColumnAlign::words}, {"mean"}}, {}, {}};
  table.add({{"optimistic", CellTone::alarm}, 2.5});
  return table;
}

TEST(TextPage, ShowsLinesAndTablesInTheirOrder) {
  const ReportTable first = table_titled("First"), second = table_titled("Second"),
                    last = table_titled("Last");
  Document document("Study");
  document.answer = {CellTone::good, "All is well"};
  document.show_answer();
  document.show_apart({first, second});
  document.show({"a line", ""});
  document.brief.emplace_back(last);
  document.paragraph("for the page alone");
  EXPECT_EQ(text_page(document), "All is well.\n\n" + text_table(first) + "\n" + text_table(second) +
                                     "\na line\n\n" + text_table(last));
}

TEST(TextPage, IsEmptyWhereNothingIsToBeShown) { EXPECT_EQ(text_page(Document("Study")), ""); }

TEST(TextPage, TablesTakeColourAndWidth) {
  const ReportTable table = table_titled("A title that is too long for a narrow terminal");
  Document document;
  document.brief.emplace_back(table);
  EXPECT_EQ(text_page(document, true, 20), text_table(table, true, 20));
  EXPECT_NE(text_page(document, true, 20), text_page(document));
}

TEST(TextPage, LinesTakeTheWidth) {
  Document document;
  document.show({"a line that is too long", "  short"});
  EXPECT_EQ(text_page(document, false, 12), "a line that\nis too long\n  short\n");
}

TEST(TextPage, LinesHoldNoControlCharacters) {
  const std::string evil = "a\x1b[31mb\nc\r\x07";
  Document document;
  document.show({evil});
  EXPECT_EQ(text_page(document), printable_line(evil) + "\n");
  EXPECT_EQ(text_page(document), "a [31mb c  \n");
}

}  // namespace
}  // namespace credence::internal
