#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "analysis/evidence/sums/evidence.h"

namespace credence::internal {

/// The bytes that a result store keeps of the evidence of a chunk; exact.
std::vector<std::byte> to_bytes(const Evidence& evidence);

/// Reads them back; throws std::runtime_error for bytes that are none of ours, of another version, or of
/// another layout.
Evidence evidence_from_bytes(std::span<const std::byte> bytes, const RunLayout& layout);

}  // namespace credence::internal
