#pragma once

#include <string>
#include <string_view>

namespace credence::internal {

/// Takes what LaTeX has a command for off the front of `text`: a character that it reads as one of its own, a
/// Greek letter, a sign of mathematics; as it is written in text. Other letters come as they are. `text` must
/// not be empty.
std::string_view take_latex(std::string_view& text);

/// Words as LaTeX is told them.
std::string latex_words(std::string_view words);

}  // namespace credence::internal
