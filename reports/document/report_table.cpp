#include "reports/document/report_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/number_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

bool is_number(const std::string& text) {
  const std::size_t first = text.find_first_of("0123456789");
  if (first == std::string::npos) return false;
  const std::string sign = text.substr(0, first);
  const bool starts_well = sign.empty() || sign == "-" || sign == "+" || sign == "\u2212";
  const std::size_t end = text.find_first_not_of("0123456789.", first);
  return starts_well && (end == std::string::npos || text[end] == 'e');
}

// Characters from the decimal point on: "1.25" -> 3, "7" -> 0.
std::size_t decimals_of(const std::string& text) {
  const std::size_t point = text.find('.');
  return point == std::string::npos ? 0 : text.size() - point;
}

std::string repeated(const std::string& unit, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += unit;
  return all;
}

}  // namespace

TableCell::TableCell(std::string words, CellTone cell_tone) : text(std::move(words)), tone(cell_tone) {}
TableCell::TableCell(const char* words, CellTone cell_tone) : text(words), tone(cell_tone) {}
TableCell::TableCell(double value, int significant)
    : text(std::isnan(value) ? "–" : number_text(value, significant)) {}

void ReportTable::add(std::vector<TableCell> row) {
  if (row.size() != columns.size()) {
    throw std::invalid_argument(
        fmt::format("table '{}': row of {} cells for {} columns", title, row.size(), columns.size()));
  }
  rows.push_back(std::move(row));
}

void ReportTable::remove_column(std::ptrdiff_t column) {
  columns.erase(columns.begin() + column);
  for (std::vector<TableCell>& row : rows) row.erase(row.begin() + column);
}

std::vector<std::string> align_decimals(const ReportTable& table, std::size_t column,
                                        const std::string& space, const std::string& point) {
  std::vector<std::string> texts;
  std::size_t longest = 0;
  for (const auto& row : table.rows) {
    texts.push_back(printable_line(row[column].text));
    // An exponent has no decimal point to share with its neighbours.
    if (is_number(texts.back()) && texts.back().find('e') == std::string::npos) {
      longest = std::max(longest, decimals_of(texts.back()));
    }
  }
  for (std::string& text : texts) {
    if (!is_number(text) || text.find('e') != std::string::npos) continue;
    const std::size_t decimals = decimals_of(text);
    if (decimals == 0 && longest > 0) text += point + repeated(space, longest - 1);
    if (decimals > 0) text += repeated(space, longest - decimals);
  }
  return texts;
}

}  // namespace credence::internal
