#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "datasets/logs/bytes/byte_cursor.h"

namespace credence::internal {

/// The bytes of a file, read in pieces: memory is held for the largest piece asked for and never for more
/// than the file holds.
///
/// Every error is a DataError that names the file, and the byte where there is one.
class BinaryFile {
 public:
  /// Throws DataError when there is no such file, or it is no regular one.
  explicit BinaryFile(const std::filesystem::path& file);

  std::uint64_t size() const { return size_; }
  const std::filesystem::path& path() const { return origin_.file; }
  const ByteOrigin& origin() const { return origin_; }

  /// The bytes from `at` on, valid until the next call. Throws DataError when the file ends before; `what`
  /// they are is named in it.
  Bytes view(std::uint64_t at, std::uint64_t count, std::string_view what);

  /// The same, to be read one after another.
  ByteCursor cursor(std::uint64_t at, std::uint64_t count, std::string_view what,
                    std::endian order = std::endian::little) {
    return {view(at, count, what), origin_, at, order};
  }

  [[noreturn]] void fail(std::uint64_t at, const std::string& problem) const;

 private:
  ByteOrigin origin_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t begin_ = 0, end_ = 0;  ///< of what the buffer holds, in the file
};

}  // namespace credence::internal
