#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "datasets/logs/bytes/append_number.h"

namespace credence::internal {

/// The CRC-32 of `content`, as zlib has it.
inline void append_crc32(std::string& bytes, std::string_view content) {
  const uLong checksum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  append_number(bytes, static_cast<std::uint32_t>(checksum));
}

}  // namespace credence::internal
