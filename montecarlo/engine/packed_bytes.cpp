#include "montecarlo/engine/packed_bytes.h"

#include <zstd.h>

#include <stdexcept>

namespace credence::internal {
namespace {

constexpr int kLevel = 1;
/// A row of SQLite has less; a damaged frame must not allocate more.
constexpr unsigned long long kMostUnpacked = 1'000'000'000;
/// A block is the content of so many bytes at most, and takes so many at least (RFC 8878, section 3.1.1.2): a
/// frame of a few bytes must not allocate a gigabyte either.
constexpr unsigned long long kMostOfBlock = 128 * 1024, kLeastBlock = 3;

std::size_t checked(std::size_t size) {
  if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
  return size;
}

}  // namespace

std::vector<std::byte> packed(std::span<const std::byte> bytes) {
  std::vector<std::byte> frame(ZSTD_compressBound(bytes.size()));
  frame.resize(checked(ZSTD_compress(frame.data(), frame.size(), bytes.data(), bytes.size(), kLevel)));
  return frame;
}

std::vector<std::byte> unpacked(std::span<const std::byte> frame) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size > kMostUnpacked) throw std::runtime_error("no frame of a known size");  // errors are the largest
  if (size / kMostOfBlock > frame.size() / kLeastBlock)
    throw std::runtime_error("more than its frame can hold");
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  bytes.resize(checked(ZSTD_decompress(bytes.data(), bytes.size(), frame.data(), frame.size())));
  return bytes;
}

}  // namespace credence::internal
