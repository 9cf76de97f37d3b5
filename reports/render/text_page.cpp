#include "reports/render/text_page.h"

#include "reports/render/text_table.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

/// In lines of so many columns; 0: in one.
std::string shown_line(const std::string& line, std::size_t width) {
  const std::string printable = printable_line(line);
  if (width == 0) return printable + "\n";
  std::string lines;
  for (const std::string& part : wrapped_lines(printable, width)) lines += part + "\n";
  return lines;
}

}  // namespace

std::string text_page(const Document& document, bool colour, std::size_t width) {
  std::string text;
  for (const auto& each : document.brief) {
    if (const auto* line = std::get_if<std::string>(&each)) text += shown_line(*line, width);
    if (const auto* table = std::get_if<ReportTable>(&each)) text += text_table(*table, colour, width);
  }
  return text;
}

}  // namespace credence::internal
