#pragma once

#include <string>

#include "reports/figures/gnuplot_svg_tag.h"

/// @file
/// Markers in gnuplot's SVG arrive one by one as uses of a symbol (a hundred bytes each, and ids that would
/// clash between the figures of a page). A run of equal ones becomes one path here.

namespace credence {

class SvgMarkerRun {
 public:
  /// Whether the <use> element `tag` continues the run.
  bool continues(const SvgTag& tag) const;
  /// Adds a <use> element; std::runtime_error for a symbol that our scripts do not ask for.
  void add(const SvgTag& tag);
  /// The path of the run, which ends; empty without markers.
  std::string take();

 private:
  std::string symbol_, size_, colour_, path_;
};

}  // namespace credence
