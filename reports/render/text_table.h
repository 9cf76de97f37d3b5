#pragma once

#include <cstddef>
#include <string>

#include "reports/document/report_table.h"

/// @file
/// Tables on a terminal.

namespace credence::internal {

/// `table` as aligned lines of UTF-8 text, title above, notes below, each line ended by a line break. With
/// `colour`, tones become ANSI colours (the caller knows whether stdout is a terminal).
///
/// width > 0: no line is longer, but for a word that is. Cells of words are broken between words for that;
/// where this is not enough, each row becomes a paragraph of "title  text" lines below its first cell. width
/// = 0: one line a row.
std::string text_table(const ReportTable& table, bool colour = false, std::size_t width = 0);

}  // namespace credence::internal
