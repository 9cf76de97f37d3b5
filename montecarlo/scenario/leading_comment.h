#pragma once

#include <istream>
#include <string>

namespace credence::internal {

/// What the author of a scenario says of it: the first paragraph of comment before its first setting, as one
/// line of text without its marks. Empty where there is none, or nothing to read.
std::string leading_comment(std::istream& scenario);

}  // namespace credence::internal
