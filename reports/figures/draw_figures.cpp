#include "reports/figures/draw_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/parallel_tasks.h"
#include "reports/figures/cairo_canvas.h"
#include "reports/figures/figure_layout.h"
#include "reports/figures/figure_painter.h"
#include "reports/figures/panel_data.h"
#include "reports/figures/pgf_canvas.h"
#include "reports/figures/svg_canvas.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {
namespace {

// A page shows up to four columns side by side.
double page_width(const Figure& figure) {
  return figure.cols == 1 ? 620.0 : figure.cols == 2 ? 940.0 : figure.cols == 3 ? 1080.0 : 1180.0;
}

// A paper has one or two columns of text to offer. Long names beside a single panel may need the second.
double paper_width(const Figure& figure, PaperStyle::Width wanted) {
  constexpr double kUnitsPerInch = 72.0 / kPaperFontPoints * kLabelFont;
  constexpr double kOne = 3.5 * kUnitsPerInch, kTwo = 7.16 * kUnitsPerInch;
  constexpr double kLeastShare = 0.45;  // of the width, for the axes
  if (wanted == PaperStyle::Width::one_column) return kOne;
  if (wanted == PaperStyle::Width::two_columns || figure.cols > 1) return kTwo;
  return lay_out(figure, kOne).panels.front().box.width() < kLeastShare * kOne ? kTwo : kOne;
}

// Panels side by side are too narrow in one column of text: there they stand below each other.
Figure arranged(Figure figure, PaperStyle::Width wanted) {
  if (wanted == PaperStyle::Width::one_column && figure.cols > 1) {
    figure.rows = static_cast<int>(figure.panels.size());
    figure.cols = 1;
  }
  return figure;
}

template <class FormatCanvas, class... Options>
std::string render(const Figure& figure, double width, const Options&... options) {
  validate(figure);
  const FigureLayout layout = lay_out(figure, width);
  FormatCanvas canvas(layout.width, layout.height, figure.caption.empty() ? figure.name : figure.caption,
                      options...);
  paint_figure(figure, layout, canvas);
  return std::move(canvas).finish();
}

using FileFormat = std::pair<const char*, std::string (*)(const Figure&, double, const PaperStyle&)>;

// The formats of a style, the first of which a reader is offered first.
std::vector<FileFormat> file_formats(const PaperStyle& style) {
  using enum CairoCanvas::Format;
  std::vector<FileFormat> formats;
  if (style.pdf) {
    formats.emplace_back(".pdf", [](const Figure& figure, double width, const PaperStyle& s) {
      return render<CairoCanvas>(figure, width, CairoCanvas::Options{pdf, s.serif});
    });
  }
  if (style.svg) {
    formats.emplace_back(".svg", [](const Figure& figure, double width, const PaperStyle& s) {
      return s.width == PaperStyle::Width::by_figure ? render_svg(figure) : render<SvgCanvas>(figure, width);
    });
  }
  if (style.png) {
    formats.emplace_back(".png", [](const Figure& figure, double width, const PaperStyle& s) {
      return render<CairoCanvas>(figure, width, CairoCanvas::Options{png, s.serif});
    });
  }
  if (style.pgf) {
    formats.emplace_back(".pgf", [](const Figure& figure, double width, const PaperStyle&) {
      return render<PgfCanvas>(figure, width);
    });
  }
  return formats;
}

std::vector<std::filesystem::path> write_figure(const Figure& figure, const std::filesystem::path& folder,
                                                const PaperStyle& style) {
  std::vector<std::filesystem::path> files;
  const Figure on_paper = arranged(figure, style.width);
  validate(on_paper);
  const double width = paper_width(on_paper, style.width);
  for (const auto& [ending, drawn] : file_formats(style)) {
    files.push_back(folder / (figure.name + ending));
    write_file(files.back(), drawn(on_paper, width, style));
  }
  return files;
}

void write_panels(const Figure& figure, const std::filesystem::path& folder, const PaperStyle& style) {
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    write_figure({.name = fmt::format("{}-{}", figure.name, i + 1),
                  .caption = figure.caption,
                  .panels = {figure.panels[i]}},
                 folder, style);
  }
}

void draw_panels(const Figure& figure, Drawing& drawing) {
  const FigureLayout layout = lay_out(figure, page_width(figure));
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const Panel& panel = figure.panels[i];
    const CanvasBox& cell = layout.panels[i].cell;
    SvgCanvas canvas(cell, panel.title.empty() ? figure.caption : panel.title.text);
    paint_panel(panel, layout.panels[i], canvas);
    drawing.panels.push_back({std::move(canvas).finish(), panel_data(panel, layout.panels[i])});
    if (i < static_cast<std::size_t>(figure.cols)) drawing.column_widths.push_back(cell.width());
  }
}

Drawing draw(const Figure& figure) {
  Drawing drawing{.svg = render_svg(figure), .caption = figure.caption};
  draw_panels(figure, drawing);
  return drawing;
}

}  // namespace

std::string render_svg(const Figure& figure) { return render<SvgCanvas>(figure, page_width(figure)); }

std::vector<Drawing> draw_all(std::span<const Figure> figures, const ReportFolder& folder) {
  const std::filesystem::path place = folder / "figures";
  const std::filesystem::path panels = place / "panels";
  const auto has_panels = [](const Figure& figure) { return figure.panels.size() > 1; };
  make_directories(std::ranges::any_of(figures, has_panels) ? panels : place);
  std::vector<Drawing> drawings(figures.size());
  for_each_task(static_cast<std::int64_t>(figures.size()), 0, nullptr, [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    const Figure& figure = figures[at];
    drawings[at] = draw(figure);
    drawings[at].files = write_figure(figure, place, folder.paper);
    if (has_panels(figure)) write_panels(figure, panels, folder.paper);
  });
  return drawings;
}

}  // namespace credence::internal
