#pragma once

#include <span>
#include <string_view>

namespace credence::internal {

/// A file of the project that the program carries with it, so that it works wherever it is installed.
struct EmbeddedFile {
  std::string_view path;  ///< within the project
  std::string_view text;
};

/// All of them: the scenarios, the examples of own filters, and the schemas of the JSON documents.
std::span<const EmbeddedFile> embedded_files();

}  // namespace credence::internal
