#include "datasets/logs/number_field.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/trim_blanks.h"

namespace credence::internal {
namespace {

/// Whether a number that no double holds is below those that one does: by its exponent, or, without one, as
/// it begins with 0.
bool is_tiny(std::string_view field) {
  const std::size_t exponent = field.find_first_of("eE");
  if (exponent != std::string_view::npos) return field.substr(exponent + 1).starts_with('-');
  return field.substr(field.starts_with('-') ? 1 : 0).starts_with("0.");
}

}  // namespace

std::optional<double> parse_finite(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double number = 0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, number);
  if (error == std::errc::result_out_of_range && stop == end && is_tiny(field)) return 0.0;
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::string shown_field(std::string_view text) {
  std::string result(text.substr(0, 24));
  for (char& letter : result)
    if (letter < ' ' || letter > '~') letter = '?';
  return result;
}

std::string_view trim_quotes(std::string_view field) {
  const bool quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
  return quoted ? trim_blanks(field.substr(1, field.size() - 2)) : field;
}

std::vector<std::string_view> comma_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(trim_quotes(trim_blanks(line.substr(begin, end - begin))));
    begin = end + 1;
  }
  return fields;
}

std::vector<std::string_view> words_between(std::string_view blanks, std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(blanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blanks, end);
  }
  return words;
}

}  // namespace credence::internal
