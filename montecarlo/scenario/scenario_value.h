#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace credence::internal {

/// A value that is no boolean, number or string: its TOML type, for messages.
struct OtherValue {
  std::string type;
  bool operator==(const OtherValue&) const = default;
};
using ScalarValue = std::variant<bool, std::int64_t, double, std::string, OtherValue>;

/// Arrays in an array, such as the rows of a matrix.
using NestedArray = std::vector<std::vector<ScalarValue>>;

/// A value as written in TOML. An array of which every element is an array is a NestedArray; what is deeper
/// is an OtherValue.
using SettingValue = std::variant<ScalarValue, std::vector<ScalarValue>, NestedArray>;

/// One key as given by a file or on the command line.
struct Setting {
  std::string section;
  std::string key;
  SettingValue value;
  std::string
      place;  ///< `file:7: [noise] measurement_variance = -1` or `--set noise.measurement_variance=-1`
};

/// TOML text of a number in the fewest digits that read back to the same double; always a float, "1.0".
std::string real_text(double value);

/// TOML text of a string, quoted; control characters are escaped.
std::string quoted_text(std::string_view text);

/// A foreign text for a message: control characters escaped, cut short after some `longest` bytes.
std::string shown_text(std::string_view text, std::size_t longest = 60);

/// TOML text of a value; of what is neither scalar nor array, its type. Cut short, for messages.
std::string value_text(const ScalarValue& value);
std::string value_text(const SettingValue& value);

/// The same, but arrays in full.
std::string full_text(const SettingValue& value);

/// The type of a value with its article: "the string", "the number".
std::string_view type_text(const SettingValue& value);

/// The word of `words` that `word` may be a misspelling of, or an empty string.
std::string_view closest_word(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace credence::internal
