#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace credence::internal {

/// The finite number that a field is, as a whole, with or without '+'; nothing for anything else (words, nan,
/// inf, trailing characters, an empty field).
std::optional<double> parse_finite(std::string_view field);

/// A time of a text that is larger is in nanoseconds, as those since 1970.
inline constexpr double kLargestSeconds = 1e16;

/// What of a text may stand in an error message: its beginning, without control characters.
std::string shown_field(std::string_view text);

/// `field` without the quotes around it, and without blanks within them.
std::string_view trim_quotes(std::string_view field);

/// The fields of a line between commas, without blanks at their ends and the quotes around them.
std::vector<std::string_view> comma_fields(std::string_view line);

/// The words of a line between any of these characters.
std::vector<std::string_view> words_between(std::string_view blanks, std::string_view line);

}  // namespace credence::internal
