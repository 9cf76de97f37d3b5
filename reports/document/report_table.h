#pragma once

#include <concepts>
#include <string>
#include <vector>

/// @file
/// A table as data; text_table.h shows it on a terminal, html_page.h on a page.

namespace credence::internal {

/// What a cell says to a reader in a hurry. The words of the cell must say it too: colour is never alone.
enum class CellTone { plain, good, caution, alarm, muted };

/// One cell: its text as a person reads it. Numbers convert by number_text with four significant digits.
struct TableCell {
  TableCell(std::string words,
            CellTone cell_tone = CellTone::plain);  // NOLINT: cells are written as literals
  TableCell(const char* words, CellTone cell_tone = CellTone::plain);  // NOLINT
  TableCell(double value, int significant = 4);                        // NOLINT
  template <std::integral Integer>
  TableCell(Integer value)
      : TableCell(value < 0 ? "\u2212" + std::to_string(value).substr(1) : std::to_string(value)) {
  }  // NOLINT

  std::string text;
  CellTone tone = CellTone::plain;
  std::string link{};  ///< on a page: "#anchor", or an address relative to it; empty: none
};

/// What a report comes to, in a sentence that can be acted on.
struct ReportAnswer {
  CellTone tone = CellTone::plain;
  std::string text;  ///< without a full stop
};

/// Words stand left; numbers stand right with their decimal points below each other.
enum class ColumnAlign { words, numbers };

struct TableColumn {
  std::string title;
  ColumnAlign align = ColumnAlign::numbers;
};

struct ReportTable {
  std::string title{};
  std::vector<TableColumn> columns{};
  std::vector<std::vector<TableCell>> rows{};
  std::vector<std::string> notes{};

  /// Appends a row; std::invalid_argument unless it has one cell for each column.
  void add(std::vector<TableCell> row);
  /// Takes a column out, counted from 0.
  void remove_column(std::ptrdiff_t column);
};

/// The texts of one column of numbers, padded behind by `space` so that right alignment puts the decimal
/// points below each other. `point` pads for a missing decimal point.
std::vector<std::string> align_decimals(const ReportTable& table, std::size_t column,
                                        const std::string& space, const std::string& point);

}  // namespace credence::internal
