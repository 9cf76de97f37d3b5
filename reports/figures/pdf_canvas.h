#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "reports/figures/canvas.h"

namespace credence {

/// Draws a PDF of one page with cairo, its fonts embedded, to stand in a paper: the label font is 8 pt.
/// Letters that the sans-serif font at hand lacks show as boxes. Every call throws std::runtime_error with
/// cairo's message when cairo fails, which takes a lack of memory.
class PdfCanvas : public Canvas {
 public:
  /// `description` becomes the subject of the document.
  PdfCanvas(double width, double height, std::string_view description);
  ~PdfCanvas() override;

  void stroke(std::span<const CanvasPath> lines, const Pen& pen) override;
  void fill(std::span<const CanvasPath> outlines, const Brush& brush) override;
  void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) override;

  /// The bytes of the file; the canvas is closed then.
  std::string finish() &&;

 private:
  struct Page;  // cairo stays out of this header
  std::unique_ptr<Page> page_;
};

inline constexpr double kPdfFontPoints = 8.0;

}  // namespace credence
