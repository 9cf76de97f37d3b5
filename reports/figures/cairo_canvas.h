#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "reports/figures/canvas.h"

namespace credence::internal {

/// Draws with cairo, to stand in a paper: a PDF of one page, its fonts embedded, or a PNG on white at 300
/// dots per inch; the label font is 8 pt. Letters that the font at hand lacks show as boxes. Every call
/// throws std::runtime_error with cairo's message when cairo fails, which takes a lack of memory.
class CairoCanvas : public Canvas {
 public:
  enum class Format { pdf, png };
  struct Options {
    Format format = Format::pdf;
    bool serif = false;  ///< Times instead of Helvetica, or what the system has for them
  };
  /// `description` becomes the subject of a PDF.
  CairoCanvas(double width, double height, std::string_view description, const Options& options);
  ~CairoCanvas() override;

  void stroke(std::span<const CanvasPath> lines, const Pen& pen) override;
  void fill(std::span<const CanvasPath> outlines, const Brush& brush) override;
  void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) override;

  /// The bytes of the file; the canvas is closed then.
  std::string finish() &&;

 private:
  struct Page;  // cairo stays out of this header
  std::unique_ptr<Page> page_;
};

}  // namespace credence::internal
