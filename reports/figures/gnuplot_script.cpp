#include "reports/figures/gnuplot_script.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "reports/figures/figure_layout.h"
#include "reports/figures/gnuplot_series.h"

namespace credence {
namespace {

constexpr double kPdfFontPoints = 8.0;
constexpr double kPointsPerInch = 72.0;

// A page shows up to four columns side by side; a paper has one or two text columns to offer.
double canvas_width(const Figure& figure, GnuplotFormat format) {
  if (format == GnuplotFormat::pdf) {
    const double inches = figure.cols == 1 ? 3.5 : 7.16;
    return inches * kPointsPerInch / kPdfFontPoints * kFontUnits;
  }
  return figure.cols == 1 ? 620.0 : figure.cols == 2 ? 940.0 : figure.cols == 3 ? 1080.0 : 1180.0;
}

// Writes the commands of one figure.
class ScriptWriter {
 public:
  ScriptWriter(const Figure& figure, GnuplotFormat format)
      : figure_(figure), format_(format), layout_(lay_out(figure, canvas_width(figure, format))) {}

  std::string write() {
    terminal();
    put("set multiplot\n");
    for (std::size_t i = 0; i < figure_.panels.size(); ++i) panel(figure_.panels[i], layout_.panels[i]);
    put("unset multiplot\nunset output\n");
    return plots_.data_blocks() + script_;
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(script_), format, std::forward<Args>(args)...);
  }

  std::string quoted(const FigureText& text) const { return gnuplot_string(text, format_); }

  // A place on the canvas as gnuplot counts it, from 0 to 1.
  std::string at(double x, double y) const {
    return fmt::format("screen {:.6f},{:.6f}", x / layout_.width, y / layout_.height);
  }

  void terminal() {
    if (format_ == GnuplotFormat::svg) {
      put("set terminal svg enhanced size {:.0f},{:.0f} font 'sans,12' linewidth 1\n", layout_.width,
          layout_.height);
    } else {
      // With this fontscale points of the font are points of the page.
      const double inches_per_unit = kPdfFontPoints / kFontUnits / kPointsPerInch;
      put("set terminal pdfcairo enhanced size {:.4f}in,{:.4f}in font 'Helvetica,{}' fontscale 0.75 "
          "linewidth 0.7 pointscale 0.8\n",
          layout_.width * inches_per_unit, layout_.height * inches_per_unit, kPdfFontPoints);
    }
    put("set encoding utf8\nunset key\n");
    put("set border 3 lw 0.8 lc {}\n", gnuplot_colour(kAxisColour));
    put("set tics out nomirror scale 0.4 textcolor {}\nset xtics offset 0,0.45\n",
        gnuplot_colour(kInkColour));
  }

  void panel(const Panel& panel, const PanelLayout& layout) {
    put("unset label\nunset arrow\nunset object\nunset colorbox\n");
    put("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\n", layout.box.left / layout_.width,
        layout.box.right / layout_.width);
    put("set bmargin at screen {:.6f}\nset tmargin at screen {:.6f}\n", layout.box.bottom / layout_.height,
        layout.box.top / layout_.height);
    axis("x", layout.x);
    axis("y", layout.y);
    if (layout.has_colour_bar) {
      put("unset grid\nset border 15\n");
      colour_bar(panel, layout);
    } else {
      put("set grid back lt 1 lw 0.7 lc {}\nset border 3\n", gnuplot_colour(kGridColour));
    }
    titles(panel, layout);
    legend(panel, layout);
    for (const Series& series : panel.series) {
      plots_.add(series, layout);
      if (series.kind == SeriesKind::text) text_marks(series, layout);
    }
    if (!plots_.has_elements()) {
      put("set label {} at graph 0.5,0.5 center tc {}\n", quoted("no finite data"),
          gnuplot_colour(kAxisColour));
    }
    put("plot {}\n", fmt::join(plots_.take_elements(layout), ", "));
  }

  void axis(const char* name, const Axis& axis) {
    put("{} logscale {}\n", axis.log ? "set" : "unset", name);
    // Rounding in gnuplot's logarithms must not lose a tick at the very end.
    const double slack = axis.log ? 1e-9 : 0.0;
    put("set {}range [{:.12g}:{:.12g}]\nset {}tics (", name, axis.range.low * (1.0 - slack),
        axis.range.high * (1.0 + slack), name);
    for (const AxisTick& tick : axis.ticks) {
      put("{}{} {:.12g}", &tick == axis.ticks.data() ? "" : ", ", quoted(tick.label), tick.value);
    }
    put(")\n");
  }

  void colour_bar(const Panel& panel, const PanelLayout& layout) {
    const bool sequential = panel.colour_scale == ColourScale::sequential;
    const auto colours = sequential ? sequential_colours() : diverging_colours();
    put("set palette defined (");
    for (std::size_t i = 0; i < colours.size(); ++i) put("{}{} '#{:06x}'", i == 0 ? "" : ", ", i, colours[i]);
    put(")\n");
    axis("cb", layout.colour);
    put("set colorbox vertical user origin {} size screen {:.6f},{:.6f} noborder\n",
        at(layout.colour_bar_x, layout.box.bottom), kColourBarWidth / layout_.width,
        layout.box.height() / layout_.height);
    vertical_label(panel.colour_label, layout.colour_label_x, layout.box);
  }

  void vertical_label(const FigureText& label, double x, const PlotBox& box) {
    if (label.empty()) return;
    put("set label {} at {} center rotate by 90 tc {}\n", quoted(label), at(x, 0.5 * (box.bottom + box.top)),
        gnuplot_colour(kInkColour));
  }

  void titles(const Panel& panel, const PanelLayout& layout) {
    const std::string ink = gnuplot_colour(kInkColour);
    if (!panel.title.empty()) {
      const std::string words = quoted(panel.title);
      put("set label '{{/:Bold {}}}' at {} left tc {}\n", words.substr(1, words.size() - 2),
          at(layout.box.left, layout.title_y), ink);
    }
    if (!panel.x_label.empty()) {
      put("set label {} at {} center tc {}\n", quoted(panel.x_label),
          at(0.5 * (layout.box.left + layout.box.right), layout.x_label_y), ink);
    }
    vertical_label(panel.y_label, layout.y_label_x, layout.box);
  }

  void legend(const Panel& panel, const PanelLayout& layout) {
    for (const LegendEntry& entry : layout.legend) {
      const Series& series = panel.series[entry.series];
      const double end = entry.x + entry.sample_width;
      const bool area =
          series.kind == SeriesKind::band || (series.kind == SeriesKind::polygon && series.filled);
      const bool marked = series.kind == SeriesKind::points || series.kind == SeriesKind::error_bars;
      if (area) {
        const RoleStyle style = style_of(series.role);
        put("set object rectangle from {} to {} fc {} fs transparent solid {:.3g} noborder\n",
            at(entry.x, entry.y - 5.0), at(end, entry.y + 5.0), gnuplot_colour(style.rgb), style.tint);
      } else if (series.kind != SeriesKind::points) {
        put("set arrow from {} to {} nohead {}\n", at(entry.x, entry.y), at(end, entry.y),
            gnuplot_line(series));
      }
      if (marked) {
        put("set label '' at {} point {}\n", at(0.5 * (entry.x + end), entry.y), gnuplot_marker(series));
      }
      put("set label {} at {} left tc {}\n", quoted(series.label), at(end + 6.0, entry.y),
          gnuplot_colour(kInkColour));
    }
  }

  void text_marks(const Series& series, const PanelLayout& layout) {
    const AxisRange x = layout.x.range;
    const AxisRange y = layout.y.range;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const bool inside =
          series.x[i] >= x.low && series.x[i] <= x.high && series.y[i] >= y.low && series.y[i] <= y.high;
      if (!inside) continue;
      put("set label {} at first {:.10g},{:.10g} left offset character 0.6,0.5 front tc {}\n",
          quoted(series.texts[i]), series.x[i], series.y[i], gnuplot_colour(style_of(series.role).rgb));
    }
  }

  const Figure& figure_;
  GnuplotFormat format_;
  FigureLayout layout_;
  PlotWriter plots_;
  std::string script_;
};

}  // namespace

std::string gnuplot_script(const Figure& figure, GnuplotFormat format) {
  validate(figure);
  return ScriptWriter(figure, format).write();
}

}  // namespace credence
