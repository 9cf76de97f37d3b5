#include "reports/render/text_table.h"

#include <algorithm>
#include <string_view>

#include "reports/render/utf8_text.h"

namespace credence {
namespace {

constexpr std::string_view kColumnGap = "  ";

std::string_view ansi_of(CellTone tone) {
  switch (tone) {
    case CellTone::good:
      return "\x1b[32m";
    case CellTone::caution:
      return "\x1b[33m";
    case CellTone::alarm:
      return "\x1b[1;31m";
    case CellTone::muted:
      return "\x1b[2m";
    case CellTone::plain:
      break;
  }
  return {};
}

// One column, ready to print: all texts and the width they share.
struct Column {
  std::string title;
  ColumnAlign align;
  std::vector<std::string> texts;
  std::size_t width;
};

Column lay_out(const ReportTable& table, std::size_t index) {
  Column column{printable_line(table.columns[index].title), table.columns[index].align, {}, 0};
  if (column.align == ColumnAlign::numbers) {
    column.texts = align_decimals(table, index, " ", " ");
  } else {
    for (const auto& row : table.rows) column.texts.push_back(printable_line(row[index].text));
  }
  column.width = display_width(column.title);
  for (const std::string& text : column.texts) column.width = std::max(column.width, display_width(text));
  return column;
}

std::string padded(const std::string& text, const Column& column, std::string_view ansi) {
  const std::string space(column.width - std::min(column.width, display_width(text)), ' ');
  std::string shown = ansi.empty() ? text : std::string(ansi) + text + "\x1b[0m";
  return column.align == ColumnAlign::numbers ? space + shown : shown + space;
}

void end_line(std::string& out) {
  out.erase(out.find_last_not_of(' ') + 1);
  out += '\n';
}

}  // namespace

std::string text_table(const ReportTable& table, bool colour) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(lay_out(table, i));

  std::string out;
  if (!table.title.empty()) out += printable_line(table.title) + "\n\n";
  for (const Column& column : columns) {
    out += padded(column.title, column, {});
    out += kColumnGap;
  }
  end_line(out);
  for (const Column& column : columns) {
    for (std::size_t i = 0; i < column.width; ++i) out += "─";
    out += kColumnGap;
  }
  end_line(out);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      out += padded(columns[i].texts[row], columns[i], colour ? ansi_of(table.rows[row][i].tone) : "");
      out += kColumnGap;
    }
    end_line(out);
  }
  for (const std::string& note : table.notes) {
    out += '\n';
    out += printable_line(note);
  }
  if (!table.notes.empty()) out += '\n';
  return out;
}

}  // namespace credence
