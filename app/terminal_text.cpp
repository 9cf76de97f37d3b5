#include "app/terminal_text.h"

#include <unistd.h>

#include "reports/render/text_table.h"

namespace credence {

std::string terminal_text(const ReportTable& table) { return text_table(table, isatty(STDOUT_FILENO) == 1); }

}  // namespace credence
