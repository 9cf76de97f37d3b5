#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "reports/figures/figure.h"

/// @file
/// Draws figures with the gnuplot program.

namespace credence {

/// gnuplot is missing, failed or took too long; the message says which, for a reader of the report.
class GnuplotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Gnuplot {
  std::string program = "gnuplot";  ///< a path, or a name to look up in PATH
  std::chrono::milliseconds timeout{20'000};
};

/// One <svg> element to stand in a web page. Throws GnuplotError, or std::invalid_argument (see validate).
std::string render_svg(const Figure& figure, const Gnuplot& gnuplot = {});

/// The bytes of a PDF file of one page, sized for one or two columns of a paper.
std::string render_pdf(const Figure& figure, const Gnuplot& gnuplot = {});

/// A figure that was drawn, or the reason why not.
struct Drawing {
  std::string svg;            ///< empty when there is a problem
  std::string problem;        ///< empty when drawn
  std::filesystem::path pdf;  ///< the file written, if one was asked for
};

/// Draws all figures, several at a time; with `pdf_folder`, each also as <name>.pdf in that (existing)
/// folder. Trouble with gnuplot is data in the drawings; throws OutputError when a PDF cannot be written and
/// std::invalid_argument for an invalid figure.
std::vector<Drawing> draw_all(std::span<const Figure> figures, const std::filesystem::path& pdf_folder = {},
                              const Gnuplot& gnuplot = {});

/// Why figures could not be drawn, one reason for each of them; empty when all were.
std::vector<std::string> problems_of(std::span<const Drawing> drawings);

}  // namespace credence
