#include "reports/render/text_page.h"

#include "reports/render/text_table.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {

std::string text_page(const Document& document, bool colour, std::size_t width) {
  std::string text;
  for (const auto& each : document.brief) {
    if (const auto* line = std::get_if<std::string>(&each)) text += printable_line(*line) + "\n";
    if (const auto* table = std::get_if<ReportTable>(&each)) text += text_table(*table, colour, width);
  }
  return text;
}

}  // namespace credence::internal
