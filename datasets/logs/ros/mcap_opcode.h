#pragma once

#include <cstdint>

namespace credence::internal {

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

}  // namespace credence::internal
