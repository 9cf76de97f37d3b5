#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace credence::internal {

/// The code point that starts at `position`, which is moved behind it; U+FFFD for an invalid byte.
char32_t next_code_point(std::string_view text, std::size_t& position);

/// Appends `code_point` in UTF-8; U+FFFD for a number that is no code point.
void append_utf8(std::string& out, char32_t code_point);

/// The beginning of `text`, at most so many bytes, cut between two code points.
std::string_view beginning_of_text(std::string_view text, std::size_t longest);

}  // namespace credence::internal
