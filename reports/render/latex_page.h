#pragma once

#include <string>
#include <string_view>

#include "reports/document/document.h"

namespace credence::internal {

/// One printable line of text for LaTeX: its special characters escaped, "1.2e−5" as a power of ten, and what
/// pdflatex does not know from the letters of a paper in mathematics.
std::string escape_latex(std::string_view text);

/// What a terminal shows, for a paper: every table as a tabular in a table, with the rules of booktabs, its
/// title as caption; sentences and notes are comments.
std::string latex_page(const Document& document);

}  // namespace credence::internal
