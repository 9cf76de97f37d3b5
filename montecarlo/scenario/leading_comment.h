#pragma once

#include <filesystem>
#include <string>

namespace credence {

/// What the author of a scenario file says of it: the lines of comment before its first setting, as one line
/// of text without their marks. Empty where there is none, or no file to read.
std::string leading_comment(const std::filesystem::path& file);

}  // namespace credence
