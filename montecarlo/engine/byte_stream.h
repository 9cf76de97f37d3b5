#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// @file
/// Values as bytes one after the other, as this machine has them, to be stored or sent and read back exactly.

namespace credence::internal {

static_assert(std::endian::native == std::endian::little, "what is stored and sent is little-endian");

template <class T>
concept PlainValue =
    std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_convertible_v<T, std::string_view>;

/// Values of other types go through their own functions write_value(writer, value) and read_value(reader,
/// value).
class ByteWriter {
 public:
  template <class T>
  requires requires(ByteWriter& w, const T& value) { write_value(w, value); }
  void put(const T& value) { write_value(*this, value); }
  template <PlainValue T>
  void put(const T& value) {
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void put(std::string_view text) { put(std::as_bytes(std::span(text.data(), text.size()))); }
  void put(std::span<const std::byte> bytes) {
    put(static_cast<std::uint64_t>(bytes.size()));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    for (const T& value : values) put(value);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Throws std::runtime_error where the bytes are not what is asked for.
class ByteReader {
 public:
  /// `what`: of which these are the bytes, for messages.
  ByteReader(std::span<const std::byte> bytes, const char* what) : bytes_(bytes), what_(what) {}

  template <class T>
  requires requires(ByteReader& r, T& value) { read_value(r, value); }
  void get(T& value) { read_value(*this, value); }
  template <PlainValue T>
  void get(T& value) {
    if (bytes_.size() < sizeof(T)) refuse("ends too early");
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
  }
  void get(bool& value) {
    const auto byte = get<std::uint8_t>();
    if (byte > 1) refuse("has something else where a yes or no is kept");
    value = byte == 1;
  }
  template <PlainValue T>
  T get() {
    T value;
    get(value);
    return value;
  }
  /// A count of items of which each takes at least `item_size` bytes: a wrong one must not allocate.
  std::size_t get_count(std::size_t item_size) {
    const auto n = get<std::uint64_t>();
    if (n > bytes_.size() / item_size) refuse("is shorter than it says");
    return static_cast<std::size_t>(n);
  }
  /// As put(span); good as long as the bytes read.
  std::span<const std::byte> get_bytes() {
    const std::size_t size = get_count(1);
    const auto bytes = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return bytes;
  }
  void get(std::string& text) {
    const auto bytes = get_bytes();
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  template <class T>
  void get(std::vector<T>& values) {
    const std::size_t count = get_count(1);
    reserve(values, count);
    for (std::size_t i = 0; i < count; ++i) get(values.emplace_back());
  }
  /// Makes room for so many items, but not for more bytes than are left: a wrong count must not allocate.
  template <class T>
  void reserve(std::vector<T>& values, std::size_t count) const {
    values.clear();
    values.reserve(std::min(count, bytes_.size() / sizeof(T)));
  }
  std::size_t left() const { return bytes_.size(); }  ///< bytes not read yet
  void require_end() const {
    if (!bytes_.empty()) refuse("is longer than it says");
  }
  [[noreturn]] void refuse(const char* why) const {
    throw std::runtime_error(std::string(what_) + " " + why);
  }

 private:
  std::span<const std::byte> bytes_;
  const char* what_;
};

}  // namespace credence::internal
