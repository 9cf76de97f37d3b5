#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace credence::internal::testing {

/// Bytes of numbers in little endian order, or the other one, without any padding.
class ByteWriter {
 public:
  explicit ByteWriter(std::endian order = std::endian::little) : order_(order) {}

  template <class T>
  ByteWriter& add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (order_ != std::endian::native) std::reverse(raw, raw + sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  ByteWriter& text(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::endian order_;
  std::string bytes_;
};

}  // namespace credence::internal::testing
