#include "reports/document/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nan.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Figure figure_with_a_panel(const std::string& name) {
  return {.name = name, .panels = {{.series = {line_series("", ColourRole::first, {1, 2}, {3, 4})}}}};
}

std::vector<std::string> anchors_of(const Document& document) {
  std::vector<std::string> anchors;
  for (const DocumentPart& part : document.parts()) {
    if (const auto* heading = std::get_if<part::Heading>(&part)) anchors.push_back(heading->anchor);
    if (const auto* fold = std::get_if<part::Fold>(&part)) anchors.push_back(fold->heading.anchor);
    if (const auto* drawn = std::get_if<part::DrawnFigure>(&part)) anchors.push_back(drawn->anchor);
  }
  return anchors;
}

TEST(Document, FilesOfNamesInOtherScriptsAreToldApart) {
  EXPECT_EQ(plain_name("a b-2", "x"), "a_b-2");
  EXPECT_EQ(plain_name("", "x"), "x");
  const std::string filter = plain_name("фильтр", "x"), model = plain_name("модель", "x");
  EXPECT_NE(filter, model) << "of one length";
  EXPECT_TRUE(filter.starts_with("______-")) << filter;
  EXPECT_EQ(filter.size(), 6U + 1U + 8U) << "a letter each, and a hash";
}

TEST(Document, AnchorsAreUnique) {
  Document document;
  document.section("Results");
  document.section("Results");
  document.section("結果");
  document.figures({figure_with_a_panel("a"), figure_with_a_panel("a")});
  document.folded_section("Results", "", "", true, [&] {
    document.folded("Results: more", [] {});
    document.folded("Results", [] {});
  });
  EXPECT_THAT(anchors_of(document), ElementsAre("results", "results-2", "section", "figure-a", "figure-a-2",
                                                "results-3", "results-more", "results-4"));
}

TEST(Document, AReservedAnchorIsNotGivenToAnother) {
  Document document;
  const std::string first = document.reserve("planar loop"), second = document.reserve("planar loop");
  document.section("planar loop");
  document.folded_section(
      "planar loop", "", "", true, [] {}, second);
  document.section("planar loop", first);
  EXPECT_THAT(anchors_of(document), ElementsAre("planar-loop-3", "planar-loop-2", "planar-loop"));
}

TEST(Document, LeavesOutWhatShowsNothing) {
  Document document;
  document.figure({.name = "a"});
  document.figures({{.name = "a"}, {.name = "b"}});
  Figure without_numbers = figure_with_a_panel("a");
  without_numbers.panels[0].series[0].y = {kNaN, kNaN};
  document.figure(without_numbers);
  document.bullets({});
  EXPECT_THAT(document.parts(), IsEmpty());
  document.figure(figure_with_a_panel("a"));
  EXPECT_THAT(anchors_of(document), ElementsAre("figure-a")) << "what is left out takes no anchor";
  document.bullets({"one"});
  EXPECT_EQ(document.parts().size(), 2u);
}

TEST(Document, AFoldHoldsWhatIsPutInside) {
  Document document;
  document.folded_section("Details", {"optimistic", CellTone::alarm}, "in heading", false,
                          [&] { document.paragraph("inside"); });
  document.paragraph("behind");
  const auto& parts = document.parts();
  ASSERT_EQ(parts.size(), 4u);
  const auto& fold = std::get<part::Fold>(parts[0]);
  EXPECT_EQ(fold.word.text, "optimistic");
  EXPECT_EQ(fold.line, "in heading");
  EXPECT_EQ(std::get<part::Paragraph>(parts[1]).text, "inside");
  EXPECT_TRUE(std::holds_alternative<part::FoldEnd>(parts[2]));
  EXPECT_EQ(std::get<part::Paragraph>(parts[3]).text, "behind");
}

}  // namespace
}  // namespace credence::internal
