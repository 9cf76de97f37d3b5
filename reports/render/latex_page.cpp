#include "reports/render/latex_page.h"

#include <fmt/format.h>

#include <cctype>
#include <variant>

#include "reports/render/latex_words.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// "e−5" or "e5" behind a digit, as numbers of reports have it: what it is in LaTeX, and moves `text` behind
/// it.
std::string power_of_ten(std::string_view& text) {
  constexpr std::string_view kMinus = "−";
  std::string_view rest = text.substr(1);
  const bool negative = rest.starts_with(kMinus);
  if (negative) rest.remove_prefix(kMinus.size());
  std::size_t digits = 0;
  while (digits < rest.size() && is_digit(rest[digits])) ++digits;
  if (digits == 0) return {};
  std::string power = fmt::format("$\\times10^{{{}{}}}$", negative ? "-" : "", rest.substr(0, digits));
  text = rest.substr(digits);
  return power;
}

void add_notes(const ReportTable& table, std::string& text) {
  for (const std::string& note : table.notes) text += "% " + printable_line(note) + "\n";
}

void add_table(const ReportTable& table, std::string& text) {
  if (table.columns.empty()) return add_notes(table, text);
  std::string columns;
  std::vector<std::string> titles;
  for (const TableColumn& column : table.columns) {
    columns += column.align == ColumnAlign::words ? 'l' : 'r';
    titles.push_back(escape_latex(column.title));
  }
  text += fmt::format(
      "\\begin{{table}}\n  \\centering\n  \\caption{{{}}}\n  \\begin{{tabular}}{{{}}}\n    \\toprule\n    {} "
      "\\\\\n"
      "    \\midrule\n",
      escape_latex(table.title), columns, fmt::join(titles, " & "));
  for (const std::vector<TableCell>& row : table.rows) {
    std::vector<std::string> cells;
    cells.reserve(row.size());
    for (const TableCell& cell : row) cells.push_back(escape_latex(cell.text));
    text += fmt::format("    {} \\\\\n", fmt::join(cells, " & "));
  }
  text += "    \\bottomrule\n  \\end{tabular}\n\\end{table}\n";
  add_notes(table, text);
}

}  // namespace

std::string escape_latex(std::string_view text) {
  const std::string line = printable_line(text);
  std::string out;
  for (std::string_view rest = line; !rest.empty();) {
    if (rest.front() == 'e' && !out.empty() && is_digit(out.back())) {
      if (const std::string power = power_of_ten(rest); !power.empty()) {
        out += power;
        continue;
      }
    }
    out += take_latex(rest);
  }
  return out;
}

std::string latex_page(const Document& document) {
  std::string text = "% \\usepackage{booktabs}\n";
  for (const auto& each : document.brief) {
    if (const auto* line = std::get_if<std::string>(&each); line != nullptr && !line->empty())
      text += "% " + printable_line(*line) + "\n";
    if (const auto* table = std::get_if<ReportTable>(&each)) add_table(*table, text);
  }
  return text;
}

}  // namespace credence::internal
