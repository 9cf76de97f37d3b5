#include "reports/figures/figure_painter.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/figures/figure_marker.h"
#include "reports/figures/figure_style.h"
#include "reports/figures/panel_scale.h"
#include "reports/figures/series_painter.h"

namespace credence::internal {
namespace {

constexpr double kTick = 4.0;
constexpr double kTickGap = 4.0;     // from a tick to its label
constexpr double kSampleGap = 6.0;   // from a legend's sample to its words
constexpr double kHalfLetter = 4.2;  // from the middle of a line of text to its base line

// Draws one panel.
class PanelPainter {
 public:
  PanelPainter(const Panel& panel, const PanelLayout& layout, Canvas& canvas)
      : panel_(panel), layout_(layout), canvas_(canvas), scale_(layout), series_(layout, canvas) {}

  void paint() {
    if (!layout_.has_colour_bar) group("grid", [&] { grid(); });
    series_.keep_clear(panel_);
    group(layout_.has_colour_bar ? "plot heat" : "plot", [&] {
      for (std::size_t i = 0; i < panel_.series.size(); ++i) {
        group(fmt::format("series s{}", i), [&] { series_.paint(panel_.series[i]); });
      }
    });
    if (!series_.has_painted()) nothing();
    frame();
    group("ticks", [&] {
      ticks();
      tick_labels();
    });
    if (layout_.has_colour_bar) colour_bar();
    titles();
    legend();
  }

 private:
  template <class Draw>
  void group(std::string_view name, Draw draw) {
    canvas_.begin_group(name);
    draw();
    canvas_.end_group();
  }

  void grid() {
    std::vector<CanvasPath> lines;
    for (const AxisTick& tick : layout_.x.ticks) {
      lines.push_back({{scale_.x(tick.value), box_.top}, {scale_.x(tick.value), box_.bottom}});
    }
    for (const AxisTick& tick : layout_.y.ticks) {
      lines.push_back({{box_.left, scale_.y(tick.value)}, {box_.right, scale_.y(tick.value)}});
    }
    if (!lines.empty()) canvas_.stroke(lines, {.rgb = kGridColour, .width = 0.7});
  }

  // Axes to the left and below, all around for a heat map.
  void frame() {
    std::vector<CanvasPath> lines;
    if (layout_.has_colour_bar) {
      CanvasPath around = rectangle_path(box_);
      around.push_back(around.front());
      lines.push_back(std::move(around));
    } else {
      lines.push_back({{box_.left, box_.top}, {box_.left, box_.bottom}, {box_.right, box_.bottom}});
    }
    canvas_.stroke(lines, kAxisPen);
  }

  // Outwards.
  void ticks() {
    std::vector<CanvasPath> lines;
    for (const AxisTick& tick : layout_.x.ticks) {
      const double x = scale_.x(tick.value);
      lines.push_back({{x, box_.bottom}, {x, box_.bottom + kTick}});
    }
    for (const AxisTick& tick : layout_.y.ticks) {
      const double y = scale_.y(tick.value);
      lines.push_back({{box_.left, y}, {box_.left - kTick, y}});
    }
    if (!lines.empty()) canvas_.stroke(lines, kAxisPen);
  }

  void tick_labels() {
    for (const AxisTick& tick : layout_.x.ticks) {
      const CanvasPoint at{scale_.x(tick.value), box_.bottom + kTick + 2.6 * kHalfLetter};
      canvas_.write(tick.label, at, {.anchor = TextAnchor::middle});
    }
    for (const AxisTick& tick : layout_.y.ticks) {
      const CanvasPoint at{box_.left - kTick - kTickGap, scale_.y(tick.value) + kHalfLetter};
      canvas_.write(tick.label, at, {.anchor = TextAnchor::end});
    }
  }

  void colour_bar() {
    constexpr int kBands = 64;
    const double left = layout_.colour_bar_x;
    const double right = left + kColourBarWidth;
    const double height = box_.height() / kBands;
    for (int i = 0; i < kBands; ++i) {
      // Each reaches under the next above, as cells do.
      const double bottom = box_.bottom - i * height;
      const double top = std::max(box_.top, bottom - height - 1.0);
      const CanvasPath band = rectangle_path({left, right, top, bottom});
      canvas_.fill({&band, 1}, {colour_of((i + 0.5) / kBands, panel_.colour_scale)});
    }
    std::vector<CanvasPath> ticks;
    for (const AxisTick& tick : layout_.colour.ticks) {
      const double y = box_.bottom - share_of_axis(layout_.colour, tick.value) * box_.height();
      ticks.push_back({{right, y}, {right + kTick, y}});
      canvas_.write(tick.label, {right + kTick + kTickGap, y + kHalfLetter}, {});
    }
    if (!ticks.empty()) canvas_.stroke(ticks, kAxisPen);
    vertical_label(panel_.colour_label, layout_.colour_label_x);
  }

  void vertical_label(const FigureText& label, double x) {
    if (label.empty()) return;
    const CanvasPoint at{x + kHalfLetter, 0.5 * (box_.top + box_.bottom)};
    canvas_.write(label, at, {.anchor = TextAnchor::middle, .upright = true});
  }

  void titles() {
    if (!panel_.title.empty()) {
      canvas_.write(panel_.title, {box_.left, layout_.title_y + kHalfLetter}, {.bold = true});
    }
    if (!panel_.x_label.empty()) {
      canvas_.write(panel_.x_label, {0.5 * (box_.left + box_.right), layout_.x_label_y + kHalfLetter},
                    {.anchor = TextAnchor::middle});
    }
    vertical_label(panel_.y_label, layout_.y_label_x);
  }

  void legend() {
    for (const LegendEntry& entry : layout_.legend) {
      const Series& series = panel_.series[entry.series];
      group(fmt::format("key s{}", entry.series), [&] {
        series_.paint_sample(series, entry);
        canvas_.write(series.label, {entry.x + entry.sample_width + kSampleGap, entry.y + kHalfLetter}, {});
      });
    }
  }

  void nothing() {
    const CanvasPoint middle{0.5 * (box_.left + box_.right), 0.5 * (box_.top + box_.bottom)};
    canvas_.write("no finite data", middle, {.anchor = TextAnchor::middle, .rgb = kAxisColour});
  }

  static constexpr Pen kAxisPen{.rgb = kAxisColour, .width = 0.8};

  const Panel& panel_;
  const PanelLayout& layout_;
  const CanvasBox& box_ = layout_.box;
  Canvas& canvas_;
  PanelScale scale_;
  SeriesPainter series_;
};

}  // namespace

void paint_panel(const Panel& panel, const PanelLayout& layout, Canvas& canvas) {
  PanelPainter(panel, layout, canvas).paint();
}

void paint_figure(const Figure& figure, const FigureLayout& layout, Canvas& canvas) {
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    paint_panel(figure.panels[i], layout.panels[i], canvas);
  }
}

}  // namespace credence::internal
