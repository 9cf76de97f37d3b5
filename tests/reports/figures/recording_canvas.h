#pragma once

#include <string>
#include <vector>

#include "reports/figures/canvas.h"

namespace credence::internal {

/// Keeps what is drawn, for tests to look at.
class RecordingCanvas : public Canvas {
 public:
  struct Line {
    CanvasPath path;
    Pen pen;
  };
  struct Area {
    CanvasPath outline;
    Brush brush;
  };
  struct Words {
    std::string text;
    CanvasPoint at;
    Lettering lettering;
  };

  void stroke(std::span<const CanvasPath> paths, const Pen& pen) override {
    for (const CanvasPath& path : paths) lines.push_back({path, pen});
  }
  void fill(std::span<const CanvasPath> outlines, const Brush& brush) override {
    for (const CanvasPath& outline : outlines) areas.push_back({outline, brush});
  }
  void write(const FigureText& text, CanvasPoint at, const Lettering& lettering) override {
    words.push_back({text.text, at, lettering});
  }

  /// The lines in the colour of a role.
  std::vector<CanvasPath> lines_of(ColourRole role) const {
    std::vector<CanvasPath> found;
    for (const Line& line : lines) {
      if (line.pen.rgb == style_of(role).rgb) found.push_back(line.path);
    }
    return found;
  }

  std::vector<Line> lines;
  std::vector<Area> areas;
  std::vector<Words> words;
};

}  // namespace credence::internal
