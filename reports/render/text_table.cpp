#include "reports/render/text_table.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr std::string_view kColumnGap = "  ";
constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();

std::string_view ansi_of(CellTone tone) {
  switch (tone) {
    case CellTone::good: return "\x1b[32m";
    case CellTone::caution: return "\x1b[33m";
    case CellTone::alarm: return "\x1b[1;31m";
    case CellTone::muted: return "\x1b[2m";
    case CellTone::plain: break;
  }
  return {};
}

std::string coloured(const std::string& text, std::string_view ansi) {
  return ansi.empty() || text.empty() ? text : std::string(ansi) + text + "\x1b[0m";
}

std::size_t longest_word(std::string_view text) {
  std::size_t longest = 0;
  for (const std::string& word : wrapped_lines(text, 1)) longest = std::max(longest, display_width(word));
  return longest;
}

/// One column, ready to print: all texts and the width they share.
struct Column {
  std::string title;
  ColumnAlign align;
  std::vector<std::string> texts;
  std::size_t width, least_width;
};

Column lay_out(const ReportTable& table, std::size_t index) {
  Column column{printable_line(table.columns[index].title), table.columns[index].align, {}, 0, 0};
  const bool numbers = column.align == ColumnAlign::numbers;
  if (numbers) {
    column.texts = align_decimals(table, index, " ", " ");
  } else {
    for (const auto& row : table.rows) column.texts.push_back(printable_line(row[index].text));
  }
  column.width = display_width(column.title);
  column.least_width = longest_word(column.title);
  for (const std::string& text : column.texts) {
    const std::size_t width = display_width(text);
    column.width = std::max(column.width, width);
    column.least_width = std::max(column.least_width, numbers ? width : longest_word(text));
  }
  return column;
}

/// Narrows the widest columns until all fit; false if they cannot.
bool fit(std::vector<Column>& columns, std::size_t width) {
  std::size_t total = 0;
  for (const Column& column : columns) total += column.width + kColumnGap.size();
  total -= std::min(total, kColumnGap.size());
  while (total > width) {
    Column* widest = nullptr;
    for (Column& column : columns) {
      if (column.width > column.least_width && (widest == nullptr || column.width > widest->width)) {
        widest = &column;
      }
    }
    if (widest == nullptr) return false;
    --widest->width;
    --total;
  }
  return true;
}

std::string padded(const std::string& text, const Column& column, std::string_view ansi) {
  const std::string space(column.width - std::min(column.width, display_width(text)), ' ');
  const std::string shown = coloured(text, ansi);
  return column.align == ColumnAlign::numbers ? space + shown : shown + space;
}

void end_line(std::string& out) {
  out.erase(out.find_last_not_of(' ') + 1);
  out += '\n';
}

/// Cells side by side, each in as many lines as it needs.
void add_cells(std::string& out, const std::vector<Column>& columns, const std::vector<std::string>& texts,
               const std::vector<std::string_view>& ansi) {
  std::vector<std::vector<std::string>> lines;
  std::size_t height = 1;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    lines.push_back(wrapped_lines(texts[i], columns[i].width));
    height = std::max(height, lines.back().size());
  }
  for (std::size_t line = 0; line < height; ++line) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      out += padded(line < lines[i].size() ? lines[i][line] : "", columns[i], ansi[i]);
      out += kColumnGap;
    }
    end_line(out);
  }
}

void add_grid(std::string& out, const ReportTable& table, const std::vector<Column>& columns, bool colour) {
  std::vector<std::string> titles, rules;
  for (const Column& column : columns) {
    titles.push_back(column.title);
    rules.emplace_back();
    for (std::size_t i = 0; i < column.width; ++i) rules.back() += "─";
  }
  const std::vector<std::string_view> plain(columns.size());
  add_cells(out, columns, titles, plain);
  add_cells(out, columns, rules, plain);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::vector<std::string> texts;
    std::vector<std::string_view> ansi;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      texts.push_back(columns[i].texts[row]);
      ansi.push_back(colour ? ansi_of(table.rows[row][i].tone) : "");
    }
    add_cells(out, columns, texts, ansi);
  }
}

/// Whether the first cells tell the rows apart.
bool are_named(const Column& first) {
  std::vector<std::string> names = first.texts;
  std::ranges::sort(names);
  return std::ranges::adjacent_find(names) == names.end();
}

/// Each row as a paragraph: the first cell, and below it the others behind their titles; of rows that it does
/// not tell apart that one, too.
void add_paragraphs(std::string& out, const ReportTable& table, const std::vector<Column>& columns,
                    bool colour, std::size_t width) {
  std::size_t titles = 0;
  const std::size_t first = !columns.empty() && are_named(columns.front()) ? 1 : 0;
  for (std::size_t i = first; i < columns.size(); ++i)
    titles = std::max(titles, display_width(columns[i].title));
  const std::string indent(titles + 2 * kColumnGap.size(), ' ');
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    if (row > 0) out += '\n';
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string_view ansi = colour ? ansi_of(table.rows[row][i].tone) : "";
      const std::string text = printable_line(table.rows[row][i].text);
      if (i < first) {
        out += coloured(text, ansi) + "\n";
        continue;
      }
      std::string before(kColumnGap);
      before += columns[i].title;
      before.append(indent.size() - display_width(before), ' ');
      for (const std::string& line : wrapped_lines(text, width - std::min(width - 1, indent.size()))) {
        out += std::exchange(before, indent) + coloured(line, ansi);
        end_line(out);
      }
    }
  }
}

}  // namespace

std::string text_table(const ReportTable& table, bool colour, std::size_t width) {
  if (width == 0) width = kUnbounded;
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(lay_out(table, i));

  std::string out;
  const auto add_lines = [&](const std::string& text) {
    for (const std::string& line : wrapped_lines(printable_line(text), width)) out += line + "\n";
  };
  if (!table.title.empty()) {
    add_lines(table.title);
    out += '\n';
  }
  if (fit(columns, width)) {
    if (!columns.empty()) add_grid(out, table, columns, colour);
  } else {
    add_paragraphs(out, table, columns, colour, width);
  }
  if (!table.notes.empty() && !columns.empty()) out += '\n';
  for (const std::string& note : table.notes) add_lines(note);
  return out;
}

}  // namespace credence::internal
