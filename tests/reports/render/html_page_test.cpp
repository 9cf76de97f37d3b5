#include "reports/render/html_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/reports/render/markup_check.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

// The page without its head, whose void elements and style sheet are no XML.
std::string body_of(const Document& document, const std::vector<Drawing>& drawings = {},
                    const Provenance& from = {}) {
  const std::string html = html_page(document, drawings, from, "out");
  const std::size_t start = html.find("<body>");
  return html.substr(start, html.find("</html>") - start);
}

std::string page_of(const Document& document) { return html_page(document, {}, {}); }

Figure named_figure(const std::string& name) {
  Figure figure;
  figure.name = name;
  figure.panels.push_back({.series = {line_series("", ColourRole::first, {1, 2}, {3, 4})}});
  return figure;
}

TEST(HtmlPage, HoldsItsPartsInOrder) {
  Document document("Study", "200 runs");
  document.section("Verdicts");
  document.paragraph("All is well.");
  document.callout(CellTone::good, "Consistent.");
  document.facts({{"study.runs", "200"}});
  document.folded("Details", [&] { document.bullets({"one", "two"}); });
  document.verbatim("[world]\nlandmarks = 2");
  document.section("Figures");
  document.figure(named_figure("anees"));
  const std::string body = body_of(document, {{.svg = "<svg viewBox=\"0 0 600 300\"></svg>",
                                               .caption = "Errors with 2σ bounds.",
                                               .files = {"out/figures/anees.pdf", "out/figures/anees.svg"}}});
  EXPECT_EQ(xml_problem(body), "");
  std::size_t position = 0;
  for (const char* part :
       {"href=\"#verdicts\"", "href=\"#figures\"", "<h1>Study</h1>", "200 runs", "id=\"verdicts\"",
        "All is well.", "class=\"callout good\"", "<dt>study.runs</dt><dd>200</dd>",
        "<details id=\"details\">", "<li>one</li>", "[world]\nlandmarks = 2\n</pre>", "id=\"figures\"",
        "id=\"figure-anees\"", "<svg", "Figure A.", "2σ bounds", "href=\"figures/anees.pdf\"",
        "href=\"figures/anees.svg\""}) {
    const std::size_t found = body.find(part, position);
    ASSERT_NE(found, std::string::npos) << part;
    position = found;
  }
}

TEST(HtmlPage, EveryFigureHasALetterOfItsOwn) {
  Document document("Study");
  for (const char* section : {"One", "Two"}) {
    document.section(section);
    document.figure(named_figure(section));
  }
  const Drawing drawing{.svg = "<svg viewBox=\"0 0 600 300\"></svg>", .caption = "Errors."};
  const std::string page = html_page(document, std::vector{drawing, drawing}, {});
  for (const char* letter : {"Figure A.", "Figure B."}) EXPECT_EQ(count_of(page, letter), 1) << letter;
}

// As several studies on a page, of which that which is seen first may be the last.
TEST(HtmlPage, FiguresOfAFoldedSectionAreCountedByThemselves) {
  Document document("Studies");
  document.section("One");
  document.figure(named_figure("first"));
  for (const char* study : {"Two", "Three"}) {
    document.folded_section(study, "", "", false, [&] {
      document.figure(named_figure(std::string(study) + "a"));
      document.folded("Details", [&] { document.figure(named_figure(std::string(study) + "b")); });
      document.figure(named_figure(std::string(study) + "c"));
    });
  }
  document.section("Four");
  document.figure(named_figure("last"));
  const Drawing drawing{.svg = "<svg viewBox=\"0 0 600 300\"></svg>", .caption = "Errors."};
  const std::string page = html_page(document, std::vector(8, drawing), {});
  std::string letters;
  for (std::size_t at = page.find("Figure "); at != std::string::npos; at = page.find("Figure ", at + 1))
    letters += page[at + 7];
  EXPECT_EQ(letters, "AABCABCB");
}

TEST(HtmlPage, NeedsNothingFromOutside) {
  Document document("Study");
  document.section("One");
  for (const char* outside : {"<script ", "<link", "@import", "url(", "src=", "http", "fetch("}) {
    EXPECT_THAT(page_of(document), Not(HasSubstr(outside)));
  }
  EXPECT_EQ(count_of(page_of(document), "<script>"), 1) << "its own, in the head";
}

TEST(HtmlPage, EscapesEverything) {
  const std::string evil = "\"><script>alert('x')</script>&\x01";
  Document document(evil, evil);
  document.answer = {CellTone::alarm, evil};
  document.sources = {{evil, evil}};
  document.section(evil);
  document.folded_section(evil, {evil, CellTone::alarm}, evil, false, [&] { document.folded(evil, [] {}); });
  document.paragraph(evil);
  document.bullets({evil});
  document.callout(CellTone::alarm, evil);
  document.facts({{evil, evil}});
  document.verbatim(evil);
  document.link(evil, evil);
  ReportTable table{evil, {{evil, ColumnAlign::words}, {evil}}, {}, {evil}};
  table.add({evil, {evil, CellTone::alarm}});
  table.rows[0][0].link = evil;
  document.table(table);
  document.figure(named_figure("f"));
  document.section("second");
  const std::vector<Drawing> drawings = {
      {.svg = "<svg></svg>", .caption = evil, .files = {"a/\"><script>.svg", "a/\"><script>.pdf"}}};
  const Provenance from{.version = evil, .commit = evil, .command = evil, .date = evil, .machine = evil};
  const std::string body = body_of(document, drawings, from), page = html_page(document, drawings, from);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, Not(HasSubstr("<script")));
  EXPECT_EQ(count_of(page, "<script"), 1) << "its own, in the head";
  EXPECT_EQ(page.find('\x01'), std::string::npos);
}

TEST(HtmlPage, LinksOnlyToPagesAndFiles) {
  Document document("Study");
  document.link("results", "results.json");
  document.link("project", "https://example.org/?a=1&b=2");
  document.link("evil", "javascript:alert(1)");
  document.link("evil", "JavaScript:alert(1)");
  document.link("evil", "data:text/html,x");
  EXPECT_THAT(page_of(document), HasSubstr("<a href=\"results.json\">results</a>"));
  EXPECT_THAT(page_of(document), HasSubstr("<a href=\"https://example.org/?a=1&amp;b=2\">"));
  EXPECT_EQ(count_of(body_of(document), "<a "), 3) << "these two, and the one to the text";
}

TEST(HtmlPage, TablesSayAndColourVerdicts) {
  ReportTable table{
      "Verdicts", {{"case", ColumnAlign::words}, {"mean"}, {"verdict", ColumnAlign::words}}, {}, {"note"}};
  table.add({"a", 2.5, {"optimistic", CellTone::alarm}});
  table.add({"b", 12, {"consistent", CellTone::good}});
  Document document("Study");
  document.table(table);
  const std::string body = body_of(document);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("<td class=\"alarm\">optimistic</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"good\">consistent</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"number\">2.500</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"number\">12\u2008\u2007\u2007\u2007</td>"))
      << "decimal points in line";
  EXPECT_THAT(body, HasSubstr("<b>Table 1.</b> Verdicts"));
}

TEST(HtmlPage, OfATableWithoutColumnsTheNotesStay) {
  Document document("Study");
  document.table({"Verdicts", {}, {}, {"nothing to judge"}});
  document.table({"Runs", {{"run"}}, {}, {}});
  const std::string body = body_of(document);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("<p class=\"notes\">nothing to judge</p>"));
  EXPECT_THAT(body, HasSubstr("<b>Table 1.</b> Runs"));
}

TEST(HtmlPage, AnIntervalMayGoBelowItsNumber) {
  ReportTable table{"NEES", {{"of the pose", ColumnAlign::words}}, {}, {}};
  for (const char* text : {"1.02 (0.98 … 1.06)", "ekf (1.57 times)", "two words (and more)", "(alone)",
                           "4.495 of 3.000 (optimistic)", ""})
    table.add({text});
  Document document("Study");
  document.table(table);
  const std::string body = body_of(document);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(
      body, HasSubstr("<td class=\"with-interval\">1.02 <span class=\"interval\">(0.98 … 1.06)</span></td>"));
  EXPECT_THAT(body,
              HasSubstr("<td class=\"with-interval\"><span class=\"interval\">4.495 of 3.000</span> <span "
                        "class=\"interval\">(optimistic)</span></td>"));
  EXPECT_THAT(body, HasSubstr("<td>two words (and more)</td>"));
  EXPECT_THAT(body, HasSubstr("<td>(alone)</td>"));
}

TEST(HtmlPage, TheAnswerComesFirstAndIsKeptForAnIndex) {
  Document document("Study");
  document.section("Verdicts");
  document.answer = {CellTone::alarm, "Do not trust “a”"};
  const std::string body = body_of(document);
  EXPECT_LT(body.find("id=\"answer\""), body.find("<h2"));
  EXPECT_THAT(page_of(document), HasSubstr("<meta name=\"credence-answer\" content=\"Do not trust “a”.\">"));
}

TEST(HtmlPage, RowsLeadToSectionsThatComeLater) {
  Document document("Study");
  const std::string anchor = document.reserve("planar loop");
  document.section("planar loop");
  ReportTable table{"Verdicts", {{"study", ColumnAlign::words}}, {}, {}};
  table.add({"planar loop"});
  table.rows[0][0].link = "#" + anchor;
  document.table(table);
  document.folded_section(
      "planar loop", "", "", true, [&] { document.paragraph("inside"); }, anchor);
  const std::string body = body_of(document);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("<a href=\"#planar-loop\">planar loop</a></td>"));
  EXPECT_EQ(count_of(body, "id=\"planar-loop\""), 1);
  EXPECT_THAT(body, HasSubstr("<h2 id=\"planar-loop-2\">")) << "another section of that name has its own";
  EXPECT_LT(body.find("<details class=\"section\" id=\"planar-loop\" open=\"\">"), body.find("inside"));
}

TEST(HtmlPage, WordsLinkToTheirExplanationAtFirstUse) {
  Document document("Study");
  document.paragraph("NEES, and NEES again; no ANEESX.");
  const std::string body = body_of(document);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_EQ(count_of(body, "href=\"#word-nees\""), 1);
  EXPECT_EQ(count_of(body, "<dt id=\"word-nees\">NEES</dt>"), 1);
  EXPECT_THAT(body, Not(HasSubstr("word-anees"))) << "only whole words, and only those used";
  EXPECT_THAT(visible_text(body), HasSubstr("NEES, and NEES again; no ANEESX."));
}

TEST(HtmlPage, SaysWhereItComesFrom) {
  Document document("Study");
  document.sources = {{"seed", "7"}};
  const std::string body = body_of(document, {},
                                   {.version = "1.2.3",
                                    .commit = "abc",
                                    .command = "credence run a.toml",
                                    .date = "2026-01-02 03:04:05",
                                    .machine = "a machine"});
  for (const char* fact : {"Credence 1.2.3", "abc", "credence run a.toml", "2026-01-02 03:04:05 UTC",
                           "a machine", "<dt>seed</dt><dd>7</dd>"}) {
    EXPECT_THAT(body, HasSubstr(fact));
  }
}

TEST(HtmlPage, CellsWithoutAValueAreNoBrightestOnesInTheDark) {
  EXPECT_THAT(page_of(Document("A page")),
              HasSubstr(fmt::format("figure svg [fill=\"#{:06x}\"] {{ fill: #757b82; }}", kMissingColour)));
}

TEST(HtmlPage, PanelsBringTheirNumbers) {
  Drawing drawing{.svg = "<svg/>"};
  drawing.panels = {{"<svg>one</svg>", "{}"}, {"<svg>two</svg>", "{}"}};
  drawing.column_widths = {300.0, 200.0};
  Document document("Study");
  document.figure(named_figure("pair"));
  const std::string body = body_of(document, {drawing});
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("--columns:300fr 200fr;max-width:500px"));
  EXPECT_EQ(count_of(body, "<script type=\"application/json\">{}</script></div>"), 2);
}

}  // namespace
}  // namespace credence::internal
