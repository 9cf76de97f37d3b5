#include "datasets/logs/text_table.h"

#include <fmt/format.h>

#include <string_view>

#include "core/trim_blanks.h"
#include "datasets/data_error.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/number_field.h"

namespace credence::internal {
namespace {

/// Appends the numbers of one line; returns the problem, or an empty string.
std::string parse_line(std::string_view line, Index columns, std::vector<double>& numbers) {
  Index count = 0;
  for (const std::string_view word : words_between(" \t", line)) {
    const std::optional<double> number = parse_finite(word);
    if (!number) return fmt::format("'{}' is not a finite number", shown_field(word));
    numbers.push_back(*number);
    ++count;
  }
  if (count != columns) return fmt::format("{} numbers where {} are expected", count, columns);
  return "";
}

}  // namespace

void TextTable::fail(Index row, const std::string& problem) const {
  throw DataError(file, std::to_string(lines.at(static_cast<std::size_t>(row))), problem);
}

TextTable read_text_table(const std::filesystem::path& file, Index columns) {
  LineReader reader(file);
  TextTable table{file, {}, {}};
  std::vector<double> numbers;
  for (std::string_view line; reader.next(line);) {
    if (line.starts_with('#') || trim_blanks(line).empty()) continue;
    if (const std::string problem = parse_line(line, columns, numbers); !problem.empty())
      reader.fail(problem);
    table.lines.push_back(static_cast<int>(reader.line_number()));
  }
  if (table.lines.empty()) throw DataError(file, "", "holds no rows of numbers");
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  table.values = Eigen::Map<const RowMajor>(numbers.data(), static_cast<Index>(table.lines.size()), columns);
  return table;
}

}  // namespace credence::internal
