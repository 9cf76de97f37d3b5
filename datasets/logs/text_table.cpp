#include "datasets/logs/text_table.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <string_view>

#include "datasets/data_error.h"
#include "datasets/logs/number_field.h"

namespace credence::internal {
namespace {

std::string read_whole(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw DataError(file, "", "there is no such file");
  if (!std::filesystem::is_regular_file(file, error)) throw DataError(file, "", "is not a regular file");
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in && !in.eof()) throw DataError(file, "", "cannot be read");
  return text;
}

/// Appends the numbers of one line; returns the problem, or an empty string.
std::string parse_line(std::string_view line, Index columns, std::vector<double>& numbers) {
  constexpr std::string_view kBlanks = " \t\r";
  Index count = 0;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;
       begin = line.find_first_not_of(kBlanks, begin)) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    const std::optional<double> number = parse_finite(word);
    if (!number) return fmt::format("'{}' is not a finite number", shown_field(word));
    numbers.push_back(*number);
    ++count;
    begin = end;
  }
  if (count != columns) return fmt::format("{} numbers where {} are expected", count, columns);
  return "";
}

}  // namespace

void TextTable::fail(Index row, const std::string& problem) const {
  throw DataError(file, std::to_string(lines.at(static_cast<std::size_t>(row))), problem);
}

TextTable read_text_table(const std::filesystem::path& file, Index columns) {
  const std::string text = read_whole(file);
  TextTable table{file, {}, {}};
  std::vector<double> numbers;
  int number_of_line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string_view line(text.data() + begin, std::min(end, text.size()) - begin);
    const std::string place = std::to_string(++number_of_line);
    if (end == std::string::npos) throw DataError(file, place, "truncated: the last line has no end");
    begin = end + 1;
    if (line.starts_with('#') || line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    if (const std::string problem = parse_line(line, columns, numbers); !problem.empty())
      throw DataError(file, place, problem);
    table.lines.push_back(number_of_line);
  }
  if (table.lines.empty()) throw DataError(file, "", "holds no rows of numbers");
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  table.values = Eigen::Map<const RowMajor>(numbers.data(), static_cast<Index>(table.lines.size()), columns);
  return table;
}

}  // namespace credence::internal
