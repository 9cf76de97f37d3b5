#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "reports/figures/figure.h"

/// @file
/// What a figure is drawn on: lines, areas and words. figure_painter.h draws every figure with these three;
/// each output format implements them.

namespace credence::internal {

/// Lengths are in units of 1/12 of the label font's size, from the upper left corner to the right and down.
struct CanvasPoint {
  double x = 0.0, y = 0.0;
  bool operator==(const CanvasPoint&) const = default;
};
using CanvasPath = std::vector<CanvasPoint>;

struct CanvasBox {
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

struct Pen {
  std::uint32_t rgb = 0;
  double width = 1.0;
  StrokeStyle stroke = StrokeStyle::solid;  ///< never by_role
  bool dots = false;                        ///< round ends: a path of one point is a dot of the pen's width
};

/// Lengths of the dashes of a line and of the gaps between them.
struct Dashes {
  double on = 0.0, off = 0.0;
};
constexpr Dashes dashes_of(StrokeStyle stroke, double width) {
  // Longer on thick lines, and still several in a legend.
  return stroke == StrokeStyle::dotted ? Dashes{1.0 + 0.5 * width, 1.5 + 0.7 * width}
                                       : Dashes{4.0 + width, 2.5 + 0.5 * width};
}

struct Brush {
  std::uint32_t rgb = 0;
  double opacity = 1.0;
};

enum class TextAnchor { start, middle, end };

struct Lettering {
  TextAnchor anchor = TextAnchor::start;
  std::uint32_t rgb = kInkColour;
  bool bold = false;
  bool upright = false;  ///< reads from the bottom up
};

inline constexpr double kLabelFont = 12.0;
inline constexpr double kPaperFontPoints = 8.0;  ///< of the label font, on paper
inline constexpr double kScriptFont = 9.0;       ///< of sub- and superscripts
inline constexpr double kSuperscript = 4.5;      ///< that their base line lies above that of the text
inline constexpr double kSubscript = 2.5;        ///< below

class Canvas {
 public:
  Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  virtual ~Canvas() = default;

  /// Open lines. Coordinates are finite, here and below.
  virtual void stroke(std::span<const CanvasPath> lines, const Pen& pen) = 0;
  /// Areas, closed by themselves; where outlines of one call overlap, they are filled once.
  virtual void fill(std::span<const CanvasPath> outlines, const Brush& brush) = 0;
  /// Words whose anchor on the base line is at `at`.
  virtual void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) = 0;

  /// What is drawn until the matching end belongs together, under a name that a page can refer to ("series
  /// s2"). A format that cannot name things does nothing.
  virtual void begin_group(std::string_view /*name*/) {}
  virtual void end_group() {}
};

}  // namespace credence::internal
