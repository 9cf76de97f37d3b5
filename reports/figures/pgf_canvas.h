#pragma once

#include <string>
#include <string_view>

#include "reports/figures/canvas.h"

namespace credence::internal {

/// Draws a picture for LaTeX's package pgf, whose words LaTeX sets in the letters of the paper: \input it,
/// with \usepackage{pgf} in the preamble. The label font is 8 pt.
class PgfCanvas : public Canvas {
 public:
  /// `description` becomes a comment.
  PgfCanvas(double width, double height, std::string_view description);

  void stroke(std::span<const CanvasPath> lines, const Pen& pen) override;
  void fill(std::span<const CanvasPath> outlines, const Brush& brush) override;
  void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) override;

  /// The picture; the canvas is closed then.
  std::string finish() &&;

 private:
  void trace(std::span<const CanvasPath> paths, bool close);
  double height_;
  std::string pgf_;
};

}  // namespace credence::internal
