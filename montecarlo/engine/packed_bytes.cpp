#include "montecarlo/engine/packed_bytes.h"

#include <zstd.h>

#include <algorithm>
#include <stdexcept>

namespace credence::internal {
namespace {

constexpr int kLevel = 1;
/// A row of SQLite has less; a damaged frame must not allocate more.
constexpr unsigned long long kMostUnpacked = 1'000'000'000;
/// What the blocks of a frame can hold, by their heads (RFC 8878, section 3.1.1): a frame whose size is
/// damaged must not allocate for it. Of no frame: 0.
unsigned long long most_content(std::span<const std::byte> frame) {
  constexpr std::size_t kMagic = 4, kBlockHead = 3;
  constexpr unsigned long long kMostOfBlock = 128 * 1024;
  const auto at = [&](std::size_t i) { return std::to_integer<std::size_t>(frame[i]); };
  if (frame.size() <= kMagic) return 0;
  const std::size_t descriptor = at(kMagic);
  const bool one_segment = (descriptor & 0x20U) != 0;
  constexpr std::size_t kDictionaryBytes[] = {0, 1, 2, 4}, kSizeBytes[] = {0, 2, 4, 8};
  const std::size_t size_bytes = descriptor >> 6U == 0 && one_segment ? 1 : kSizeBytes[descriptor >> 6U];
  std::size_t next = kMagic + 1 + (one_segment ? 0 : 1) + kDictionaryBytes[descriptor & 3U] + size_bytes;
  unsigned long long most = 0;
  for (bool last = false; !last && frame.size() >= next + kBlockHead;) {
    const std::size_t head = at(next) | at(next + 1) << 8U | at(next + 2) << 16U;
    constexpr std::size_t kRepeatedByte = 1, kCompressed = 2;
    const std::size_t type = head >> 1U & 3U, size = head >> 3U;
    last = (head & 1U) != 0;
    most += type == kCompressed ? kMostOfBlock : std::min<unsigned long long>(size, kMostOfBlock);
    next += kBlockHead + (type == kRepeatedByte ? 1 : size);
  }
  return most;
}

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
  if (size > most_content(frame)) throw std::runtime_error("more than its frame can hold");
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  bytes.resize(checked(ZSTD_decompress(bytes.data(), bytes.size(), frame.data(), frame.size())));
  return bytes;
}

}  // namespace credence::internal
