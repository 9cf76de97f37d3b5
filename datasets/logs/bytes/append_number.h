#pragma once

#include <bit>
#include <cstring>
#include <string>

namespace credence::internal {

/// Appends a number as it lies in memory, which is little-endian, without padding.
template <class T>
void append_number(std::string& bytes, T value) {
  static_assert(std::endian::native == std::endian::little);
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

}  // namespace credence::internal
