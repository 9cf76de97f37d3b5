#pragma once

#include <string>

#include "reports/figures/figure.h"
#include "reports/figures/gnuplot_text.h"

/// @file
/// A figure in gnuplot's language.

namespace credence {

/// Commands that draw `figure` to gnuplot's standard output. Texts of the figure stay texts (gnuplot_string).
/// Throws std::invalid_argument (see validate).
std::string gnuplot_script(const Figure& figure, GnuplotFormat format);

}  // namespace credence
