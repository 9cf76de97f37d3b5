#pragma once

#include <string>
#include <vector>

#include "reports/figures/figure.h"

/// @file
/// The words of a figure: their markup and the room they take.

namespace credence::internal {

enum class TextLevel { base, subscript, superscript };

struct TextRun {
  std::string words;  ///< literal, one printable line
  TextLevel level = TextLevel::base;
};

/// `text` split at its `_{...}` and `^{...}`, if it has markup; a mark without an end is literal.
std::vector<TextRun> text_runs(const FigureText& text);

/// Room that `text` takes in the label font, in canvas units, whichever sans-serif font is at hand: advance
/// widths of Helvetica, with what wider fonts need on top.
double text_width(const FigureText& text);

}  // namespace credence::internal
