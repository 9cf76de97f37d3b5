#pragma once

#include <string>

#include "reports/figures/figure.h"

/// @file
/// Texts of a figure in gnuplot's language.

namespace credence {

enum class GnuplotFormat { svg, pdf };

/// `text` as a single-quoted string for gnuplot's enhanced text mode, in which nothing but the text's own
/// markup acts: it can neither end its string nor start a command, a substitution or other markup. For SVG,
/// characters special to XML or gnuplot travel as private-use code points, which clean_svg turns into
/// entities.
std::string gnuplot_string(const FigureText& text, GnuplotFormat format);

/// Where a character that is special to gnuplot or XML travels in the private-use area.
inline constexpr char32_t kEscapedCharacters = 0xE000;

}  // namespace credence
