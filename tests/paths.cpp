#include "tests/paths.h"

namespace credence::internal {

std::filesystem::path source_folder() { return CREDENCE_SOURCE_DIR; }

std::filesystem::path credence_binary() { return CREDENCE_BINARY; }

}  // namespace credence::internal
