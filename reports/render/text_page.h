#pragma once

#include <cstddef>
#include <string>

#include "reports/document/document.h"

namespace credence::internal {

/// A document as a terminal shows it: its tables (text_table) and lines. Control characters of lines are
/// escaped.
std::string text_page(const Document& document, bool colour = false, std::size_t width = 0);

}  // namespace credence::internal
