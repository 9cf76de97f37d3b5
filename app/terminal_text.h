#pragma once

#include <cstddef>
#include <string>

#include "reports/document/document.h"

namespace credence::internal {

/// Columns of the terminal behind a descriptor; 0 where it is none, or does not say.
std::size_t terminal_width(int descriptor);

/// For stdout: on a terminal as wide as that, and in colour unless NO_COLOR is set or TERM is "dumb";
/// elsewhere each row of a table in one line.
std::string terminal_text(const Document& document);
std::string terminal_text(const ReportTable& table);

}  // namespace credence::internal
