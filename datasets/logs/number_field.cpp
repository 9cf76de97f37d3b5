#include "datasets/logs/number_field.h"

#include <charconv>
#include <cmath>

namespace credence::internal {

std::optional<double> parse_finite(std::string_view field) {
  double number = 0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::string shown_field(std::string_view text) {
  std::string result(text.substr(0, 24));
  for (char& letter : result)
    if (letter < ' ' || letter > '~') letter = '?';
  return result;
}

std::string_view trim_blanks(std::string_view field) {
  const std::size_t first = field.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return field.substr(first, field.find_last_not_of(" \t") - first + 1);
}

}  // namespace credence::internal
