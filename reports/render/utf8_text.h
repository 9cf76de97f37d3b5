#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// @file
/// What reports need to know of UTF-8: names of scenarios and files are other people's bytes.

namespace credence::internal {

/// `text` as one line that is safe to show: invalid UTF-8 becomes U+FFFD; control characters (so also line
/// breaks and terminal escapes), bidirectional overrides and private-use characters become a space or vanish.
std::string printable_line(std::string_view text);

/// A JSON document whose strings hold what printable_line would not leave: the same with these characters as
/// "\u009b", so that a terminal that it is printed to obeys none of them.
std::string printable_json(std::string json);

/// Columns that `text` takes on a terminal: 0 for combining marks, 2 for wide East Asian characters, else 1.
/// Expects what printable_line returns.
std::size_t display_width(std::string_view text);

/// The text in lines of at most `width` columns, broken between words; a longer word has a line of its own.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width);

/// Whether `c` is one of the bytes of `set`.
inline bool is_in(char c, std::string_view set) { return set.find(c) != std::string_view::npos; }

}  // namespace credence::internal
