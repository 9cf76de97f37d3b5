#include "reports/figures/draw_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/parallel_tasks.h"
#include "reports/figures/figure_layout.h"
#include "reports/figures/figure_painter.h"
#include "reports/figures/panel_data.h"
#include "reports/figures/pdf_canvas.h"
#include "reports/figures/svg_canvas.h"
#include "reports/render/atomic_file.h"

namespace credence {
namespace {

constexpr const char* kPanelFolder = "panels";

// A page shows up to four columns side by side.
double page_width(const Figure& figure) {
  return figure.cols == 1 ? 620.0 : figure.cols == 2 ? 940.0 : figure.cols == 3 ? 1080.0 : 1180.0;
}

// A paper has one or two columns of text to offer.
double paper_width(const Figure& figure) {
  constexpr double kPointsPerInch = 72.0;
  const double inches = figure.cols == 1 ? 3.5 : 7.16;
  return inches * kPointsPerInch / kPdfFontPoints * kLabelFont;
}

template <class FormatCanvas>
std::string render(const Figure& figure, double width) {
  validate(figure);
  const FigureLayout layout = lay_out(figure, width);
  FormatCanvas canvas(layout.width, layout.height, figure.caption.empty() ? figure.name : figure.caption);
  paint_figure(figure, layout, canvas);
  return std::move(canvas).finish();
}

void write_panels(const Figure& figure, const std::filesystem::path& folder) {
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const Figure alone{.name = fmt::format("{}-{}", figure.name, i + 1),
                       .caption = figure.caption,
                       .panels = {figure.panels[i]}};
    write_file(folder / (alone.name + ".pdf"), render_pdf(alone));
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

Drawing draw(const Figure& figure, const std::filesystem::path& folder) {
  Drawing drawing{.svg = render_svg(figure)};
  draw_panels(figure, drawing);
  if (folder.empty()) return drawing;
  drawing.svg_file = folder / (figure.name + ".svg");
  drawing.pdf_file = folder / (figure.name + ".pdf");
  write_file(drawing.svg_file, drawing.svg);
  write_file(drawing.pdf_file, render_pdf(figure));
  if (figure.panels.size() > 1) write_panels(figure, folder / kPanelFolder);
  return drawing;
}

}  // namespace

std::string render_svg(const Figure& figure) { return render<SvgCanvas>(figure, page_width(figure)); }

std::string render_pdf(const Figure& figure) { return render<PdfCanvas>(figure, paper_width(figure)); }

std::vector<Drawing> draw_all(std::span<const Figure> figures, const std::filesystem::path& folder) {
  std::vector<Drawing> drawings(figures.size());
  const bool has_panels = std::ranges::any_of(figures, [](const Figure& f) { return f.panels.size() > 1; });
  if (has_panels && std::filesystem::is_directory(folder)) make_directories(folder / kPanelFolder);
  for_each_task(static_cast<std::int64_t>(figures.size()), 0, nullptr, [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    drawings[at] = draw(figures[at], folder);
  });
  return drawings;
}

}  // namespace credence
