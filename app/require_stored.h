#pragma once

#include <filesystem>

namespace credence::internal {

/// Throws StoreError where the store that was written is no longer in its folder: reports are written after
/// the last commit, which sees that by itself.
void require_stored(const std::filesystem::path& directory);

}  // namespace credence::internal
