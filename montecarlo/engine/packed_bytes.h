#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace credence::internal {

/// Bytes as a frame of Zstandard that knows its size (RFC 8878). Level 1: what is stored are moments, of
/// which the parts that repeat are found at any level and the others at none.
std::vector<std::byte> packed(std::span<const std::byte> bytes);

/// Throws std::runtime_error for what packed did not make.
std::vector<std::byte> unpacked(std::span<const std::byte> frame);

}  // namespace credence::internal
