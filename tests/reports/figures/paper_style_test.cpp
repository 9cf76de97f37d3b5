#include "reports/figures/paper_style.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using Width = PaperStyle::Width;

PaperStyle style_of_words(const std::vector<std::string>& words) { return paper_style(words); }

std::string formats_of(const PaperStyle& style) {
  return std::string(style.svg ? "svg " : "") + (style.pdf ? "pdf " : "") + (style.png ? "png " : "") +
         (style.pgf ? "pgf " : "");
}

TEST(PaperStyle, WithoutAWordIsSvgAndPdfAsWideAsTheFigure) {
  const PaperStyle style = style_of_words({});
  EXPECT_EQ(formats_of(style), "svg pdf ");
  EXPECT_EQ(style.width, Width::by_figure);
  EXPECT_FALSE(style.serif);
}

TEST(PaperStyle, FormatsThatAreNamedTakeThePlaceOfTheseTwo) {
  EXPECT_EQ(formats_of(style_of_words({"png"})), "png ");
  EXPECT_EQ(formats_of(style_of_words({"pgf", "svg"})), "svg pgf ");
  EXPECT_EQ(formats_of(style_of_words({"svg", "pdf", "png", "pgf"})), "svg pdf png pgf ");
  EXPECT_EQ(formats_of(style_of_words({"serif", "one-column"})), "svg pdf ") << "no format is named";
}

TEST(PaperStyle, WidthAndLetteringStayBesideTheFormats) {
  const PaperStyle one = style_of_words({"one-column", "pdf"}),
                   two = style_of_words({"serif", "two-columns"});
  EXPECT_EQ(one.width, Width::one_column);
  EXPECT_FALSE(one.serif);
  EXPECT_EQ(two.width, Width::two_columns);
  EXPECT_TRUE(two.serif);
  EXPECT_EQ(style_of_words({"one-column", "one-column"}).width, Width::one_column) << "twice the same";
}

TEST(PaperStyle, EveryWordThatIsOfferedIsTakenAndNoOther) {
  EXPECT_THAT(paper_words(), ElementsAre("svg", "pdf", "png", "pgf", "one-column", "two-columns", "serif"));
  for (const std::string_view word : paper_words()) EXPECT_NO_THROW(style_of_words({std::string(word)}));
  for (const char* word : {"eps", "SVG", "", "one column"}) {
    EXPECT_THAT(
        [&] {
          style_of_words({"pdf", word});
        },
        ThrowsMessage<std::invalid_argument>(
            std::string("'") + word + "' is none of svg, pdf, png, pgf, one-column, two-columns, serif"));
  }
  EXPECT_THAT(
      [] {
        style_of_words({"two-columns", "one-column"});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("exclude each other")));
}

TEST(ReportFolder, IsItsPathWithAStyle) {
  const ReportFolder plain = "out";
  EXPECT_EQ(plain / "a.svg", std::filesystem::path("out/a.svg"));
  EXPECT_TRUE(plain.paper.pdf);
  const ReportFolder styled(std::filesystem::path("out"), style_of_words({"png"}));
  EXPECT_EQ(styled.path, "out");
  EXPECT_FALSE(styled.paper.pdf);
  const std::filesystem::path& path = styled;
  EXPECT_EQ(path, "out");
}

}  // namespace
}  // namespace credence::internal
