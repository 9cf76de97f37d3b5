#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace credence::internal {

using Bytes = std::span<const std::uint8_t>;

/// Where bytes come from, for error messages.
struct ByteOrigin {
  std::filesystem::path file;
  std::string inside;  ///< "" for the file itself, else what was unpacked: "the chunk at byte 4117"
};

/// Reads numbers and texts one after another from bytes that nobody has checked.
///
/// Every read is checked against the bytes that are there: what does not fit is a DataError that names the
/// file and the byte. Numbers are in `order`, at any alignment.
class ByteCursor {
 public:
  /// The bytes begin at byte `begin` of the origin, which must outlive this.
  ByteCursor(Bytes bytes, const ByteOrigin& origin, std::uint64_t begin,
             std::endian order = std::endian::little)
      : bytes_(bytes), origin_(&origin), begin_(begin), order_(order) {}

  template <class T>
  T take() {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    std::uint8_t raw[sizeof(T)];
    const Bytes from = take_bytes(sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      raw[i] = from[order_ == std::endian::native ? i : sizeof(T) - 1 - i];
    }
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  Bytes take_bytes(std::uint64_t count) {
    if (count > left()) fail_short(count);
    const Bytes taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }

  std::string_view take_text(std::uint64_t count) {
    const Bytes taken = take_bytes(count);
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }

  void skip(std::uint64_t count) { take_bytes(count); }

  void set_order(std::endian order) { order_ = order; }

  std::uint64_t left() const { return bytes_.size() - at_; }
  std::uint64_t taken() const { return at_; }
  std::uint64_t position() const { return begin_ + at_; }  ///< in the origin
  bool done() const { return left() == 0; }

  /// A cursor over the next `count` bytes, which this one passes over.
  ByteCursor part(std::uint64_t count) {
    const std::uint64_t from = position();
    return {take_bytes(count), *origin_, from, order_};
  }

  /// Throws DataError at the byte that comes next, or at another one.
  [[noreturn]] void fail(const std::string& problem) const { fail_at(position(), problem); }
  [[noreturn]] void fail_at(std::uint64_t position, const std::string& problem) const;

 private:
  [[noreturn]] void fail_short(std::uint64_t count) const;

  Bytes bytes_;
  const ByteOrigin* origin_;
  std::uint64_t begin_;
  std::size_t at_ = 0;
  std::endian order_;
};

template <class T>
double take_double(ByteCursor& from) {
  return static_cast<double>(from.take<T>());
}

}  // namespace credence::internal
