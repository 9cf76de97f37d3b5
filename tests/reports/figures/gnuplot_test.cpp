#include "reports/figures/gnuplot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "reports/figures/gnuplot_script.h"
#include "reports/render/atomic_file.h"
#include "tests/reports/render/markup_check.h"
#include "tests/temporary_folder.h"

namespace credence {
namespace {

using testing::HasSubstr;

Figure figure_of(std::vector<Series> series, const std::string& name = "test") {
  Panel panel;
  panel.title = "(a) Errors";
  panel.x_label = "step";
  panel.y_label = "error (m²)";
  panel.series = std::move(series);
  Figure figure;
  figure.name = name;
  figure.caption = "A caption.";
  figure.panels = {panel};
  return figure;
}

Series simple_line() { return line_series("mean", ColourRole::estimate, {1, 2, 3}, {1, 4, 2}); }

// Sets PATH for one scope.
class PathOverride {
 public:
  explicit PathOverride(const std::string& path) : old_(std::getenv("PATH") ? std::getenv("PATH") : "") {
    setenv("PATH", path.c_str(), 1);
  }
  ~PathOverride() { setenv("PATH", old_.c_str(), 1); }

 private:
  std::string old_;
};

// A program that stands for gnuplot.
std::filesystem::path fake_gnuplot(const TemporaryFolder& folder, const std::string& script) {
  const auto path = folder / "gnuplot";
  write_file(path, "#!/bin/sh\n" + script);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

std::string error_of(const Gnuplot& gnuplot) {
  try {
    render_svg(figure_of({simple_line()}), gnuplot);
  } catch (const GnuplotError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Gnuplot, DrawsEverySeriesAsWellFormedSvg) {
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
  const std::string svg = render_svg(figure);
  EXPECT_EQ(xml_problem(svg), "");
  for (const char* label : {"(a) Errors", "step", "error (m²)", "bounds", "line", "steps", "points", "level",
                            "upright", "bars", "area", "mark", "trace"}) {
    EXPECT_THAT(visible_text(svg), HasSubstr(label));
  }
  EXPECT_THAT(svg, HasSubstr("stroke=\"#0072b2\"")) << "the colour of estimates";
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray")) << "bounds are dashed in the legend of lines";
  EXPECT_GE(count_of(svg, "<polygon"), 7) << "band, area, five known cells";
  EXPECT_EQ(svg.find(" id="), std::string::npos) << "ids would clash between the figures of a page";
}

TEST(Gnuplot, DrawsEveryMarker) {
  std::vector<Series> all;
  for (const auto shape : {MarkerShape::dot, MarkerShape::plus, MarkerShape::cross, MarkerShape::square,
                           MarkerShape::triangle, MarkerShape::diamond}) {
    all.push_back(point_series("", ColourRole::first, {1, 2}, {1, 2}));
    all.back().marker = shape;
  }
  EXPECT_EQ(xml_problem(render_svg(figure_of(all))), "");
}

TEST(Gnuplot, BreaksLinesAtPointsThatAreNotFinite) {
  const std::string script = gnuplot_script(
      figure_of({line_series("", ColourRole::first, {1, 2, 3}, {1, std::nan(""), 3})}), GnuplotFormat::svg);
  EXPECT_THAT(script, HasSubstr("1 1\n\n3 3\n"));
  EXPECT_EQ(script.find("nan"), std::string::npos);
}

TEST(Gnuplot, APointWithoutNeighboursIsStillSeen) {
  const Series lone = line_series("", ColourRole::estimate, {1, 2, 3, 4}, {1, std::nan(""), 2, 3});
  EXPECT_THAT(render_svg(figure_of({lone})), HasSubstr("stroke-linecap=\"round\""));
  const Series joined = line_series("", ColourRole::estimate, {3, 4}, {2, 3});
  EXPECT_THAT(render_svg(figure_of({joined})), testing::Not(HasSubstr("stroke-linecap=\"round\"")));
}

TEST(Gnuplot, NothingFiniteGivesAxesAndAWord) {
  for (const Series& series : {line_series("x", ColourRole::first, {}, {}),
                               line_series("x", ColourRole::first, {1, 2}, {std::nan(""), INFINITY}),
                               band_series("x", ColourRole::bound, {1}, {std::nan("")}, {1})}) {
    EXPECT_THAT(visible_text(render_svg(figure_of({series}))), HasSubstr("no finite data"));
  }
}

TEST(Gnuplot, ExtremeValuesAreDrawn) {
  for (const double scale : {1e-300, 1e-9, 1e9, 1e290}) {
    const Series series = line_series("x", ColourRole::first, {1, 2}, {-scale, scale});
    EXPECT_EQ(xml_problem(render_svg(figure_of({series}))), "") << scale;
  }
  EXPECT_NO_THROW(render_svg(figure_of({level_series("", ColourRole::first, 0.0)})));
  EXPECT_NO_THROW(render_svg(figure_of({point_series("", ColourRole::first, {1e6}, {5})})));
}

TEST(Gnuplot, MarkupIsAskedForAndElseLiteral) {
  Figure figure = figure_of({simple_line()});
  figure.panels[0].title = "K_{f1} σ^2";
  EXPECT_THAT(visible_text(render_svg(figure)), HasSubstr("K_{f1} σ^2"));
  figure.panels[0].title = figure_markup("K_{f1} σ^{2} a_b {c} _{open");
  const std::string text = visible_text(render_svg(figure));
  EXPECT_THAT(text, HasSubstr("Kf1 σ2 a_b {c} _{open"));
}

TEST(Gnuplot, HostileTextStaysText) {
  const TemporaryFolder folder;
  const std::string touch = "touch " + (folder / "pwned").string();
  const std::vector<std::string> texts{
      "`" + touch + "`",
      "'; system('" + touch + "') #",
      "\"; system(\"" + touch + "\") #",
      "''; !" + touch,
      "x\n!" + touch + "\nEND\n!" + touch,
      "\\'; shell '" + touch + "'",
      "@x $0 %s %d \\n \\\\ \\047 \\U+0041 {/:Bold b} {/=99 big} a_b^c &{xx} ~a{b}",
      "</text></svg><script>alert(1)</script>",
      "]]><script>alert(1)</script><![CDATA[ &amp; &lt;",
      "\" onload=\"alert(1)",
      "trailing backslash \\",
      "trailing quote '",
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
    EXPECT_NO_THROW(render_pdf(figure)) << text;
    const bool as_given = text.find('\n') == std::string::npos && text.find('\xff') == std::string::npos;
    if (!as_given || text.empty()) continue;
    EXPECT_GE(count_of(visible_text(svg), text), 5) << text;
  }
  EXPECT_EQ(folder.entries(), 0) << "a text was run as a command";
}

TEST(Gnuplot, StringsForPdfAreEscaped) {
  EXPECT_EQ(gnuplot_string("a_b^c{d}@e&f~g\\h", GnuplotFormat::pdf), "'a\\_b\\^c\\{d\\}\\@e\\&f\\~g\\\\h'");
  EXPECT_EQ(gnuplot_string("it's\n`x`", GnuplotFormat::pdf), "'it\\047s `x`'");
  EXPECT_EQ(gnuplot_string(figure_markup("K_{f_1}^{'}"), GnuplotFormat::pdf), "'K_{f\\_1}^{\\047}'");
}

TEST(Gnuplot, ManyPointsBecomeAFewWithTheirExtremes) {
  FigureData x;
  FigureData y;
  for (int i = 0; i < 200000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(0.37 * i));
  }
  y[77777] = 123.25;
  y[150001] = -77.125;
  for (const Series& series :
       {line_series("", ColourRole::first, x, y), point_series("", ColourRole::first, x, y)}) {
    const std::string script = gnuplot_script(figure_of({series}), GnuplotFormat::svg);
    EXPECT_THAT(script, HasSubstr("77777 123.25\n"));
    EXPECT_THAT(script, HasSubstr("150001 -77.125\n"));
    EXPECT_LT(count_of(script, "\n"), 25000);
  }
  const std::string svg = render_svg(figure_of({line_series("", ColourRole::first, x, y)}));
  EXPECT_LT(svg.size(), 100'000u);
}

TEST(Gnuplot, DrawsPdf) {
  const std::string pdf = render_pdf(figure_of({simple_line()}));
  EXPECT_TRUE(pdf.starts_with("%PDF-"));
}

TEST(Gnuplot, DrawsManyFigures) {
  const TemporaryFolder folder;
  std::vector<Figure> figures;
  for (int i = 0; i < 5; ++i) figures.push_back(figure_of({simple_line()}, "figure-" + std::to_string(i)));
  const auto drawings = draw_all(figures, folder.path());
  ASSERT_EQ(drawings.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(drawings[i].problem, "");
    EXPECT_EQ(drawings[i].svg, render_svg(figures[i])) << "drawing together changes nothing";
    EXPECT_TRUE(folder.read("figure-" + std::to_string(i) + ".pdf").starts_with("%PDF-"));
  }
  EXPECT_EQ(folder.entries(), 5);
  EXPECT_TRUE(draw_all({}).empty());
}

TEST(Gnuplot, AMissingProgramIsNamed) {
  const PathOverride path("/nonexistent");
  EXPECT_THAT(error_of({}), HasSubstr("'gnuplot' was not found"));
  const std::vector<Figure> figures{figure_of({simple_line()})};
  const auto drawings = draw_all(figures);
  EXPECT_THAT(drawings[0].problem, HasSubstr("'gnuplot' was not found"));
  EXPECT_EQ(drawings[0].svg, "");
}

TEST(Gnuplot, ProblemsAreThoseOfTheFiguresThatWereNotDrawn) {
  const std::vector<Drawing> drawings{{.svg = "<svg/>", .problem = {}, .pdf = {}},
                                      {.svg = {}, .problem = "first", .pdf = {}},
                                      {.svg = "<svg/>", .problem = {}, .pdf = {}},
                                      {.svg = {}, .problem = "second", .pdf = {}}};
  EXPECT_EQ(problems_of(drawings), (std::vector<std::string>{"first", "second"}));
  EXPECT_TRUE(problems_of({}).empty());
}

TEST(Gnuplot, AFailingProgramIsReported) {
  const TemporaryFolder folder;
  const std::string fails = fake_gnuplot(folder, "echo 'line 3: no such terminal' >&2\nexit 1\n").string();
  EXPECT_THAT(error_of({.program = fails}), HasSubstr("failed with status 1: line 3: no such terminal"));
}

TEST(Gnuplot, ASlowProgramIsStopped) {
  const TemporaryFolder folder;
  const std::string sleeps = fake_gnuplot(folder, "sleep 30\n").string();
  EXPECT_THAT(error_of({.program = sleeps, .timeout = std::chrono::milliseconds(100)}),
              HasSubstr("did not finish within 0.1 s"));
}

TEST(Gnuplot, HalfAnAnswerIsAProblemAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string half =
      fake_gnuplot(folder, "cat >/dev/null\necho '<svg viewBox=\"0 0 1 1\">'\n").string();
  EXPECT_THAT(error_of({.program = half}), HasSubstr("not complete"));
  const TemporaryFolder output;
  const std::vector<Figure> figures{figure_of({simple_line()})};
  EXPECT_NE(draw_all(figures, output.path(), {.program = half})[0].problem, "");
  EXPECT_EQ(output.entries(), 0);
  EXPECT_THROW(render_pdf(figures[0], {.program = half}), GnuplotError);
}

TEST(Gnuplot, AnUnwritablePdfFolderIsAnError) {
  const std::vector<Figure> figures{figure_of({simple_line()})};
  EXPECT_THROW(draw_all(figures, "/nonexistent/folder"), OutputError);
}

TEST(Gnuplot, AnInvalidFigureIsAnError) {
  const std::vector<Figure> figures{figure_of({line_series("", ColourRole::first, {1}, {})})};
  EXPECT_THROW(render_svg(figures[0]), std::invalid_argument);
  EXPECT_THROW(draw_all(figures), std::invalid_argument);
}

}  // namespace
}  // namespace credence
