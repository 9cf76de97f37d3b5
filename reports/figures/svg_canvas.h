#pragma once

#include <string>
#include <string_view>

#include "reports/figures/canvas.h"

namespace credence::internal {

/// Draws one <svg> element, for a web page or a file of its own: no ids (many figures share a page), no
/// scripts, words as words. Coordinates have two decimals; the bytes depend on what is drawn and on nothing
/// else.
class SvgCanvas : public Canvas {
 public:
  /// `description` is for screen readers.
  SvgCanvas(double width, double height, std::string_view description);
  /// A part of a drawing, in the coordinates of the whole.
  SvgCanvas(const CanvasBox& part, std::string_view description);

  void stroke(std::span<const CanvasPath> lines, const Pen& pen) override;
  void fill(std::span<const CanvasPath> outlines, const Brush& brush) override;
  void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) override;
  void begin_group(std::string_view name) override;
  void end_group() override;

  /// The element; the canvas is closed then.
  std::string finish() &&;

 private:
  std::string svg_;
};

}  // namespace credence::internal
