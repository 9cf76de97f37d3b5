#pragma once

#include <string>

#include "reports/document/report_table.h"

/// @file
/// Tables on a terminal.

namespace credence {

/// `table` as aligned lines of UTF-8 text, title above, notes below, each line ended by a line break. With
/// `colour`, tones become ANSI colours (the caller knows whether stdout is a terminal).
std::string text_table(const ReportTable& table, bool colour = false);

}  // namespace credence
