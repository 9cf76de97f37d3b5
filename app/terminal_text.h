#pragma once

#include <string>

#include "reports/document/report_table.h"

namespace credence {

/// A table for stdout, in colour when that is a terminal.
std::string terminal_text(const ReportTable& table);

}  // namespace credence
