#include "reports/figures/draw_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <filesystem>
#include <locale>
#include <regex>
#include <span>
#include <stdexcept>
#include <utility>

#include "reports/render/atomic_file.h"
#include "tests/reports/render/markup_check.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Figure figure_of(std::vector<Series> series, const std::string& name = "test") {
  Panel panel{.title = "(a) Errors", .x_label = "step", .y_label = "error (m²)"};
  panel.series = std::move(series);
  Figure figure;
  figure.name = name;
  figure.caption = "A caption.";
  figure.panels = {panel};
  return figure;
}

auto entries_of(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

Series simple_line() { return line_series("mean", ColourRole::estimate, {1, 2, 3}, {1, 4, 2.25}); }

std::string pdf_of(const Figure& figure, const PaperStyle& style = {}) {
  const TemporaryFolder folder;
  draw_all(std::span(&figure, 1), {folder.path(), style});
  return folder.read("figures/" + figure.name + ".pdf");
}

// A series of every kind, and a heat map.
Figure figure_of_everything() {
  const FigureData x{1, 2, 3, std::nan(""), 5};
  const FigureData y{1, 4, 2, 2, 3};
  Series filled = polygon_series("area", ColourRole::second, {1, 2, 2}, {1, 1, 2});
  filled.filled = true;
  Figure figure = figure_of(
      {band_series("bounds", ColourRole::bound, x, y, {2, 5, 3, 3, 4}),
       line_series("line", ColourRole::estimate, x, y), step_series("steps", ColourRole::exact, x, y),
       point_series("points", ColourRole::measurement, x, y), level_series("level", ColourRole::neutral, 2),
       upright_series("upright", ColourRole::alarm, 2),
       error_bar_series("bars", ColourRole::third, x, y, {0, 3, 1, 1, 2}, {2, 5, 3, 3, 4}), filled,
       text_series(ColourRole::truth, {2}, {2}, {"mark"})});
  figure.panels.push_back(figure.panels[0]);
  figure.panels[1].series = {heat_series({1, 10, 100}, {1, 2}, Matrix{{1, 2, 3}, {4, std::nan(""), 6}})};
  figure.panels[1].log_x = true;
  figure.panels[1].colour_label = "trace";
  figure.cols = 2;
  return figure;
}

TEST(DrawFigures, EverySeriesBecomesWellFormedSvg) {
  const std::string svg = render_svg(figure_of_everything());
  EXPECT_EQ(xml_problem(svg), "");
  for (const char* label : {"(a) Errors", "step", "error (m²)", "bounds", "line", "steps", "points", "level",
                            "upright", "bars", "area", "mark", "trace"}) {
    EXPECT_THAT(visible_text(svg), HasSubstr(label));
  }
  EXPECT_THAT(svg, HasSubstr("stroke=\"#0072b2\"")) << "the colour of estimates";
  EXPECT_EQ(svg.find(" id="), std::string::npos) << "ids would clash between the figures of a page";
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(DrawFigures, ExtremeNumbersAreDrawn) {
  Panel log;
  log.log_x = log.log_y = true;
  log.series = {line_series("", ColourRole::first, {1e-300, 1, 1e300}, {1e-310, 0, 1e300})};
  Figure figure = figure_of({line_series("", ColourRole::first, {1, 2, 3}, {-1e299, 0, 1e299}),
                             line_series("", ColourRole::first, {-1e308, 2, 1e308}, {1e308, 2, -1e308}),
                             line_series("", ColourRole::first, {1, 2}, {5e15, 5e15 + 1})});
  figure.panels.push_back(log);
  figure.cols = 2;
  const std::string svg = render_svg(figure);
  EXPECT_EQ(xml_problem(svg), "");
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_NO_THROW(pdf_of(figure));
}

TEST(DrawFigures, EveryTextStaysText) {
  const std::vector<std::string> texts{"`touch x`",
                                       "'; system('touch x') #",
                                       "\\n \\\\ \\047 \\U+0041 {/:Bold b} a_b^c &{xx} ~a{b} %s %d {} {0}",
                                       "</text></svg><script>alert(1)</script>",
                                       "]]><script>alert(1)</script><![CDATA[ &amp; &lt;",
                                       "\" onload=\"alert(1)",
                                       "-->",
                                       "trailing backslash \\",
                                       "σ² ≤ 1 × 10⁻³ … µΔ",
                                       "one\nline\x1b[31m",
                                       "\xff\xfe invalid",
                                       ""};
  for (const std::string& text : texts) {
    Figure figure = figure_of({simple_line(), text_series(ColourRole::truth, {2}, {2}, {text})});
    Panel& panel = figure.panels[0];
    panel.title = panel.x_label = panel.y_label = panel.series[0].label = text;
    figure.caption = text;
    panel.series.push_back(line_series(figure_markup(text), ColourRole::truth, {1, 2}, {1, 2}));
    const std::string svg = render_svg(figure);
    EXPECT_EQ(xml_problem(svg), "") << text;
    EXPECT_EQ(svg.find("<script"), std::string::npos) << text;
    EXPECT_EQ(svg.find("onload=\""), std::string::npos) << text;
    EXPECT_TRUE(pdf_of(figure).starts_with("%PDF-")) << text;
    const bool as_given = text.find('\n') == std::string::npos && text.find('\xff') == std::string::npos;
    if (!as_given || text.empty()) continue;
    EXPECT_GE(count_of(visible_text(svg), text), 5) << text;
  }
}

TEST(DrawFigures, LongCurvesStaySmall) {
  FigureData x, noise, smooth;
  for (int i = 0; i < 200000; ++i) {
    x.push_back(i);
    noise.push_back(std::sin(0.37 * i));
    smooth.push_back(std::exp(-1e-5 * i));
  }
  EXPECT_LT(render_svg(figure_of({line_series("", ColourRole::first, x, noise)})).size(), 30'000u);
  EXPECT_LT(render_svg(figure_of({line_series("", ColourRole::first, x, smooth)})).size(), 5'000u);
}

// A comma as the decimal mark, and dots between thousands.
struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\1"; }
};

TEST(DrawFigures, TheLocaleChangesNothing) {
  const Figure figure = figure_of_everything();
  const std::string svg = render_svg(figure);
  const std::string pdf = pdf_of(figure);
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new Comma));
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  EXPECT_EQ(render_svg(figure), svg);
  EXPECT_EQ(pdf_of(figure), pdf);
  std::locale::global(old);
  std::setlocale(LC_ALL, before.c_str());
}

TEST(DrawFigures, FilesStandBesideEachOther) {
  const TemporaryFolder folder;
  std::vector<Figure> figures{figure_of_everything()};
  for (int i = 0; i < 5; ++i) figures.push_back(figure_of({simple_line()}, "figure-" + std::to_string(i)));
  const auto drawings = draw_all(figures, folder.path());
  ASSERT_EQ(drawings.size(), figures.size());
  const std::filesystem::path place = folder / "figures";
  for (std::size_t i = 0; i < figures.size(); ++i) {
    EXPECT_EQ(drawings[i].svg, render_svg(figures[i])) << "drawing together changes nothing";
    EXPECT_EQ(folder.read("figures/" + figures[i].name + ".svg"), drawings[i].svg);
    EXPECT_EQ(folder.read("figures/" + figures[i].name + ".pdf"), pdf_of(figures[i]));
    EXPECT_EQ(drawings[i].files,
              (std::vector{place / (figures[i].name + ".pdf"), place / (figures[i].name + ".svg")}));
  }
  EXPECT_EQ(entries_of(place), 13) << "and the folder of panels";
  for (const char* name : {"test-1.pdf", "test-2.pdf", "test-1.svg", "test-2.svg"}) {
    EXPECT_TRUE(std::filesystem::exists(place / "panels" / name)) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(place / "panels" / "figure-1-1.pdf"))
      << "the figure is its only panel";
}

TEST(DrawFigures, FormatsAreThoseOfTheStyle) {
  const TemporaryFolder folder;
  const std::vector<Figure> figures{figure_of_everything()};
  const std::vector<std::string> words{"png", "pgf", "one-column"};
  const auto drawings = draw_all(figures, {folder.path(), paper_style(words)});
  const std::filesystem::path place = folder / "figures";
  EXPECT_EQ(drawings[0].files, (std::vector{place / "test.png", place / "test.pgf"}));
  EXPECT_EQ(entries_of(place / "panels"), 4);
  EXPECT_THAT(folder.read("figures/panels/test-2.pgf"), testing::StartsWith("% "));
  EXPECT_TRUE(folder.read("figures/panels/test-2.png").starts_with("\x89PNG"));
}

// Width and height of a page in points.
std::pair<double, double> page_of(const std::string& pdf) {
  std::smatch box;
  EXPECT_TRUE(std::regex_search(pdf, box, std::regex(R"(/MediaBox \[ 0 0 ([0-9.]+) ([0-9.]+) \])")))
      << pdf.substr(0, 400);
  return {std::stod(box[1]), std::stod(box[2])};
}

TEST(DrawFigures, PanelsOfOneColumnStandBelowEachOther) {
  Figure figure = figure_of({simple_line()});
  figure.panels.push_back(figure.panels[0]);
  figure.cols = 2;
  const auto [wide, low] = page_of(pdf_of(figure));
  const auto [narrow, high] = page_of(pdf_of(figure, {.width = PaperStyle::Width::one_column}));
  EXPECT_NEAR(wide, 7.16 * 72.0, 1e-3);
  EXPECT_NEAR(narrow, 3.5 * 72.0, 1e-3);
  EXPECT_GT(high, 1.5 * low);
  figure.cols = 1;
  figure.rows = 2;
  EXPECT_NEAR(page_of(pdf_of(figure)).first, 3.5 * 72.0, 1e-3);
  EXPECT_NEAR(page_of(pdf_of(figure, {.width = PaperStyle::Width::two_columns})).first, 7.16 * 72.0, 1e-3);
}

// Of one column names and colour bar left a seventh to the cells.
TEST(DrawFigures, APanelOfLongNamesHasTwoColumnsOfText) {
  Figure figure = figure_of({heat_series({1, 2}, {1, 2}, Matrix::Identity(2, 2))});
  EXPECT_NEAR(page_of(pdf_of(figure)).first, 3.5 * 72.0, 1e-3);
  figure.panels[0].y_names = {"sensors that share a part of their noise", "none"};
  EXPECT_NEAR(page_of(pdf_of(figure)).first, 7.16 * 72.0, 1e-3);
  EXPECT_NEAR(page_of(pdf_of(figure, {.width = PaperStyle::Width::one_column})).first, 3.5 * 72.0, 1e-3)
      << "as was asked for";
}

TEST(DrawFigures, AsManyPanelsAsThereMayBeAreDrawnInOneColumn) {
  Figure figure = figure_of({simple_line()});
  figure.panels.resize(kMostPanels, figure.panels[0]);
  arrange(figure);
  const TemporaryFolder folder;
  const std::vector<std::string> words{"png", "one-column"};
  EXPECT_NO_THROW(draw_all(std::span(&figure, 1), {folder.path(), paper_style(words)}));
}

TEST(DrawFigures, AFolderThatCannotBeMadeIsAnError) {
  const std::vector<Figure> figures{figure_of({simple_line()})};
  EXPECT_THROW(draw_all(figures, std::filesystem::path("/dev/null/folder")), OutputError);
}

TEST(DrawFigures, AnInvalidFigureIsAnError) {
  const std::vector<Figure> figures{figure_of({line_series("", ColourRole::first, {1}, {})})};
  EXPECT_THROW(render_svg(figures[0]), std::invalid_argument);
  const TemporaryFolder folder;
  EXPECT_THROW(draw_all(figures, folder.path()), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
