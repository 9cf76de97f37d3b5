#pragma once

#include <cstdint>
#include <string_view>

#include "datasets/logs/ros/ros_scan.h"

namespace credence::internal {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

/// What a record of an MCAP file is (mcap.dev/spec, "Records").
struct McapOpcode {
  enum : std::uint8_t {
    kHeader = 0x01,
    kFooter = 0x02,
    kSchema = 0x03,
    kChannel = 0x04,
    kMessage = 0x05,
    kChunk = 0x06,
    kDataEnd = 0x0f,
  };
};

/// Whether a file that begins so is an MCAP.
bool begins_as_mcap(std::string_view beginning);

/// Reads the messages of an MCAP (mcap.dev/spec) without its index, so that a file needs none: plain, or in
/// chunks that are not packed or packed with lz4 or zstd, whose checksums are tested. Throws DataError with
/// the byte for all else, and for a file that ends without its end mark.
void scan_mcap(const std::filesystem::path& file, const RosVisitor& visitor);

}  // namespace credence::internal
