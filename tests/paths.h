#pragma once

#include <filesystem>

/// Where the tests find what is no part of their program.

namespace credence::internal {

std::filesystem::path source_folder();    ///< of the project
std::filesystem::path credence_binary();  ///< the built command

}  // namespace credence::internal
