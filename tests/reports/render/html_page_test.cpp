#include "reports/render/html_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reports/render/atomic_file.h"
#include "tests/reports/render/markup_check.h"
#include "tests/temporary_folder.h"

namespace credence {
namespace {

using testing::HasSubstr;
using testing::Not;

// The page without its head, whose void elements and style sheet are no XML.
std::string body_of(const HtmlPage& page) {
  const std::string html = page.str();
  const std::size_t start = html.find("<body>");
  return html.substr(start, html.find("</html>") - start);
}

Figure named_figure(const std::string& name) {
  Figure figure;
  figure.name = name;
  figure.caption = "Errors with 2σ bounds.";
  return figure;
}

TEST(HtmlPage, HoldsItsPartsInOrder) {
  HtmlPage page("Study", "200 runs");
  page.section("Verdicts");
  page.paragraph("All is well.");
  page.callout(CellTone::good, "Consistent.");
  page.facts({{"study.runs", "200"}});
  page.subsection("Details");
  page.bullets({"one", "two"});
  page.verbatim("[world]\nlandmarks = 2");
  page.section("Figures");
  page.figure(named_figure("anees"),
              {.svg = "<svg viewBox=\"0 0 600 300\"></svg>",
               .files = {"out/figures/anees.pdf", "out/figures/anees.svg"}},
              "out");
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  std::size_t position = 0;
  for (const char* part :
       {"href=\"#verdicts\"", "href=\"#figures\"", "<h1>Study</h1>", "200 runs", "id=\"verdicts\"",
        "All is well.", "class=\"callout good\"", "<dt>study.runs</dt><dd>200</dd>", "<h3 id=\"details\">",
        "<li>one</li>", "[world]\nlandmarks = 2\n</pre>", "id=\"figures\"", "id=\"figure-anees\"", "<svg",
        "Figure A.", "2σ bounds", "href=\"figures/anees.pdf\"", "href=\"figures/anees.svg\""}) {
    const std::size_t found = body.find(part, position);
    ASSERT_NE(found, std::string::npos) << part;
    position = found;
  }
}

TEST(HtmlPage, NeedsNothingFromOutside) {
  HtmlPage page("Study");
  page.section("One");
  for (const char* outside : {"<script ", "<link", "@import", "url(", "src=", "http", "fetch("}) {
    EXPECT_THAT(page.str(), Not(HasSubstr(outside)));
  }
  EXPECT_EQ(count_of(page.str(), "<script>"), 1) << "its own, in the head";
}

TEST(HtmlPage, EscapesEverything) {
  const std::string evil = "\"><script>alert('x')</script>&\x01";
  HtmlPage page(evil, evil);
  page.answer(CellTone::alarm, evil);
  page.provenance({.version = evil, .commit = evil, .command = evil, .date = evil, .machine = evil},
                  {{evil, evil}});
  page.section(evil);
  page.folded_section(evil, {evil, CellTone::alarm}, evil, false, [&] { page.folded(evil, [] {}); });
  page.subsection(evil);
  page.paragraph(evil);
  page.bullets({evil});
  page.callout(CellTone::alarm, evil);
  page.facts({{evil, evil}});
  page.verbatim(evil);
  page.link(evil, evil);
  ReportTable table{evil, {{evil, ColumnAlign::words}, {evil}}, {}, {evil}};
  table.add({evil, {evil, CellTone::alarm}});
  table.rows[0][0].link = evil;
  page.table(table);
  Figure figure = named_figure("f");
  figure.caption = evil;
  page.figure(figure, {.svg = "<svg></svg>", .files = {"a/\"><script>.svg", "a/\"><script>.pdf"}});
  page.section("second");
  EXPECT_EQ(xml_problem(body_of(page)), "");
  EXPECT_THAT(body_of(page), Not(HasSubstr("<script")));
  EXPECT_EQ(count_of(page.str(), "<script"), 1) << "its own, in the head";
  EXPECT_EQ(page.str().find('\x01'), std::string::npos);
}

TEST(HtmlPage, LinksOnlyToPagesAndFiles) {
  HtmlPage page("Study");
  page.link("results", "results.json");
  page.link("project", "https://example.org/?a=1&b=2");
  page.link("evil", "javascript:alert(1)");
  page.link("evil", "JavaScript:alert(1)");
  page.link("evil", "data:text/html,x");
  EXPECT_THAT(page.str(), HasSubstr("<a href=\"results.json\">results</a>"));
  EXPECT_THAT(page.str(), HasSubstr("<a href=\"https://example.org/?a=1&amp;b=2\">"));
  EXPECT_EQ(count_of(body_of(page), "<a "), 3) << "these two, and the one to the text";
}

TEST(HtmlPage, TablesSayAndColourVerdicts) {
  ReportTable table{
      "Verdicts", {{"case", ColumnAlign::words}, {"mean"}, {"verdict", ColumnAlign::words}}, {}, {"note"}};
  table.add({"a", 2.5, {"optimistic", CellTone::alarm}});
  table.add({"b", 12, {"consistent", CellTone::good}});
  HtmlPage page("Study");
  page.table(table);
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("<td class=\"alarm\">optimistic</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"good\">consistent</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"number\">2.500</td>"));
  EXPECT_THAT(body, HasSubstr("<td class=\"number\">12\u2008\u2007\u2007\u2007</td>"))
      << "decimal points in line";
  EXPECT_THAT(body, HasSubstr("<b>Table 1.</b> Verdicts"));
}

TEST(HtmlPage, AnIntervalMayGoBelowItsNumber) {
  ReportTable table{"NEES", {{"of the pose", ColumnAlign::words}}, {}, {}};
  for (const char* text : {"1.02 (0.98 … 1.06)", "ekf (1.57 times)", "two words (and more)", "(alone)"})
    table.add({text});
  HtmlPage page("Study");
  page.table(table);
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(
      body, HasSubstr("<td class=\"with-interval\">1.02 <span class=\"interval\">(0.98 … 1.06)</span></td>"));
  EXPECT_THAT(body, HasSubstr("<td>two words (and more)</td>"));
  EXPECT_THAT(body, HasSubstr("<td>(alone)</td>"));
}

TEST(HtmlPage, TheAnswerComesFirstAndIsKeptForAnIndex) {
  HtmlPage page("Study");
  page.section("Verdicts");
  page.answer(CellTone::alarm, "Do not trust “a”.");
  const std::string body = body_of(page);
  EXPECT_LT(body.find("id=\"answer\""), body.find("<h2"));
  EXPECT_THAT(page.str(), HasSubstr("<meta name=\"credence-answer\" content=\"Do not trust “a”.\">"));
}

TEST(HtmlPage, RowsLeadToSectionsThatComeLater) {
  HtmlPage page("Study");
  const std::string anchor = page.reserve("planar loop");
  page.section("planar loop");
  ReportTable table{"Verdicts", {{"study", ColumnAlign::words}}, {}, {}};
  table.add({"planar loop"});
  table.rows[0][0].link = "#" + anchor;
  page.table(table);
  page.folded_section(
      "planar loop", "", "", true, [&] { page.paragraph("inside"); }, anchor);
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("<a href=\"#planar-loop\">planar loop</a></td>"));
  EXPECT_EQ(count_of(body, "id=\"planar-loop\""), 1);
  EXPECT_THAT(body, HasSubstr("<h2 id=\"planar-loop-2\">")) << "another section of that name has its own";
  EXPECT_LT(body.find("<details class=\"section\" id=\"planar-loop\" open=\"\">"), body.find("inside"));
}

TEST(HtmlPage, WordsLinkToTheirExplanationAtFirstUse) {
  HtmlPage page("Study");
  page.paragraph("NEES, and NEES again; no ANEESX.");
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_EQ(count_of(body, "href=\"#word-nees\""), 1);
  EXPECT_EQ(count_of(body, "<dt id=\"word-nees\">NEES</dt>"), 1);
  EXPECT_THAT(body, Not(HasSubstr("word-anees"))) << "only whole words, and only those used";
  EXPECT_THAT(visible_text(body), HasSubstr("NEES, and NEES again; no ANEESX."));
}

TEST(HtmlPage, SaysWhereItComesFrom) {
  HtmlPage page("Study");
  page.provenance({.version = "1.2.3",
                   .commit = "abc",
                   .command = "credence run a.toml",
                   .date = "2026-01-02 03:04:05",
                   .machine = "a machine"},
                  {{"seed", "7"}});
  const std::string body = body_of(page);
  for (const char* fact : {"Credence 1.2.3", "abc", "credence run a.toml", "2026-01-02 03:04:05 UTC",
                           "a machine", "<dt>seed</dt><dd>7</dd>"}) {
    EXPECT_THAT(body, HasSubstr(fact));
  }
}

TEST(HtmlPage, PanelsBringTheirNumbers) {
  Drawing drawing{.svg = "<svg/>"};
  drawing.panels = {{"<svg>one</svg>", "{}"}, {"<svg>two</svg>", "{}"}};
  drawing.column_widths = {300.0, 200.0};
  HtmlPage page("Study");
  page.figure(named_figure("pair"), drawing);
  const std::string body = body_of(page);
  EXPECT_EQ(xml_problem(body), "");
  EXPECT_THAT(body, HasSubstr("--columns:300fr 200fr;max-width:500px"));
  EXPECT_EQ(count_of(body, "<script type=\"application/json\">{}</script></div>"), 2);
}

TEST(HtmlPage, AnchorsAreUnique) {
  HtmlPage page("Study");
  page.section("Results");
  page.section("Results");
  page.section("結果");
  page.figure(named_figure("a"), {"<svg></svg>"});
  page.figure(named_figure("a"), {"<svg></svg>"});
  for (const char* anchor :
       {"id=\"results\"", "id=\"results-2\"", "id=\"section\"", "id=\"figure-a\"", "id=\"figure-a-2\""}) {
    EXPECT_EQ(count_of(page.str(), anchor), 1) << anchor;
  }
}

TEST(HtmlPage, IsWrittenWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const HtmlPage page("Study");
  page.write(folder / "index.html");
  EXPECT_EQ(folder.read("index.html"), page.str());
  try {
    page.write(folder / "missing/index.html");
    FAIL() << "expected an error";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("missing/index.html"));
  }
}

}  // namespace
}  // namespace credence
