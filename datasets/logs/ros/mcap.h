#pragma once

#include <string_view>

#include "datasets/logs/ros/ros_scan.h"

namespace credence::internal {

/// Whether a file that begins so is an MCAP.
bool begins_as_mcap(std::string_view beginning);

/// Reads the messages of an MCAP (mcap.dev/spec) without its index, so that a file needs none: plain, or in
/// chunks that are not packed or packed with lz4 or zstd, whose checksums are tested. Throws DataError with
/// the byte for all else, and for a file that ends without its end mark.
void scan_mcap(const std::filesystem::path& file, const RosVisitor& visitor);

}  // namespace credence::internal
