#include "datasets/logs/bytes/decompress.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace credence::internal {
namespace {

constexpr std::uint64_t kLargest = std::uint64_t{1} << 30;
constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kFirstOutput = std::uint64_t{1} << 16;
constexpr int kWidestWindow = 27;  ///< of zstd, as a power of 2: what `zstd -d` takes, too

/// What one call of a library did.
struct Progress {
  std::size_t consumed = 0, produced = 0;
  bool finished = false, failed = false;
};

/// Calls `step(in, out)` until it has finished, with an output that doubles up to `size`.
template <class StepFunction>
void unpack(const ByteCursor& packed, std::uint64_t size, std::vector<std::uint8_t>& out, const char* name,
            StepFunction step) {
  ByteCursor rest = packed;
  Bytes in = rest.take_bytes(rest.left());
  std::size_t filled = 0;
  out.resize(static_cast<std::size_t>(std::min(size, kFirstOutput)));
  // A byte beyond the size tells an output that is too long from one that just fits.
  std::uint8_t beyond = 0;
  for (;;) {
    const bool full = filled == out.size();
    if (full && size == kUnknown && out.size() == kLargest) packed.fail("unpacks to more than 1 GiB");
    if (full && out.size() < size) {
      out.resize(static_cast<std::size_t>(std::min(size, 2 * static_cast<std::uint64_t>(out.size()))));
      continue;
    }
    const std::span<std::uint8_t> room = full ? std::span(&beyond, 1) : std::span(out).subspan(filled);
    const Progress p = step(in, room);
    if (p.failed) packed.fail(fmt::format("{} cannot be unpacked: corrupted", name));
    if (full && p.produced > 0) packed.fail(fmt::format("{} unpacks to more than its {} bytes", name, size));
    filled += p.produced;
    in = in.subspan(p.consumed);
    if (p.finished) break;
    if (p.consumed == 0 && p.produced == 0) packed.fail(fmt::format("{} ends too early: cut off", name));
  }
  if (size == kUnknown) return out.resize(filled);
  if (filled != size) packed.fail(fmt::format("{} unpacks to {} bytes, not to {}", name, filled, size));
}

void unpack_lz4(const ByteCursor& packed, std::uint64_t size, std::vector<std::uint8_t>& out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, LZ4F_freeDecompressionContext);
  unpack(packed, size, out, "lz4", [&](Bytes in, std::span<std::uint8_t> room) {
    Progress p{.consumed = in.size(), .produced = room.size()};
    const std::size_t hint =
        LZ4F_decompress(context.get(), room.data(), &p.produced, in.data(), &p.consumed, nullptr);
    p.failed = LZ4F_isError(hint) != 0;
    p.finished = hint == 0;
    return p;
  });
}

void unpack_zstd(const ByteCursor& packed, std::uint64_t size, std::vector<std::uint8_t>& out) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  if (!stream) throw std::bad_alloc();
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, kWidestWindow);
  unpack(packed, size, out, "zstd", [&](Bytes in, std::span<std::uint8_t> room) {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{room.data(), room.size(), 0};
    const std::size_t hint = ZSTD_decompressStream(stream.get(), &to, &from);
    if (ZSTD_getErrorCode(hint) == ZSTD_error_frameParameter_windowTooLarge) {
      packed.fail(
          "zstd with a window of more than 128 MiB: `mcap decompress` makes a copy that is not packed");
    }
    return Progress{from.pos, to.pos, hint == 0, ZSTD_isError(hint) != 0};
  });
}

/// zlib and bzip2 count in 32 bits.
unsigned int limited(std::size_t bytes) {
  return static_cast<unsigned int>(std::min<std::size_t>(bytes, std::numeric_limits<int>::max()));
}

void unpack_bz2(const ByteCursor& packed, std::uint64_t size, std::vector<std::uint8_t>& out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> owner(&stream, BZ2_bzDecompressEnd);
  unpack(packed, size, out, "bz2", [&](Bytes in, std::span<std::uint8_t> room) {
    const unsigned int given = limited(in.size()), free = limited(room.size());
    // The library never writes to its input.
    stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));
    stream.avail_in = given;
    stream.next_out = reinterpret_cast<char*>(room.data());
    stream.avail_out = free;
    const int status = BZ2_bzDecompress(&stream);
    return Progress{given - stream.avail_in, free - stream.avail_out, status == BZ_STREAM_END,
                    status != BZ_OK && status != BZ_STREAM_END};
  });
}

/// window_bits: of zlib, which names the header by them. enough: what is unpacked ends with this many bytes.
void unpack_deflate(const ByteCursor& packed, std::uint64_t size, std::vector<std::uint8_t>& out,
                    const char* name, int window_bits, std::uint64_t enough = kUnknown) {
  z_stream stream{};
  if (inflateInit2(&stream, window_bits) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&inflateEnd)> owner(&stream, inflateEnd);
  unpack(packed, size, out, name, [&](Bytes in, std::span<std::uint8_t> room) {
    const unsigned int given = limited(in.size()), free = limited(room.size());
    stream.next_in = const_cast<Bytef*>(in.data());
    stream.avail_in = given;
    stream.next_out = room.data();
    stream.avail_out = free;
    const int status = inflate(&stream, Z_NO_FLUSH);
    // Z_BUF_ERROR: there is nothing to do with these two, which the caller sees.
    const bool failed = status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR;
    const bool finished = status == Z_STREAM_END || stream.total_out >= enough;
    return Progress{given - stream.avail_in, free - stream.avail_out, finished, failed};
  });
}

}  // namespace

void decompress(Compression compression, ByteCursor packed, std::uint64_t size,
                std::vector<std::uint8_t>& out) {
  if (size > kLargest) packed.fail(fmt::format("unpacks to {} bytes; at most 1 GiB is read at once", size));
  switch (compression) {
    case Compression::none: {
      if (packed.left() != size) packed.fail(fmt::format("{} bytes where {} are said", packed.left(), size));
      const Bytes bytes = packed.take_bytes(size);
      out.assign(bytes.begin(), bytes.end());
      return;
    }
    case Compression::lz4: return unpack_lz4(packed, size, out);
    case Compression::zstd: return unpack_zstd(packed, size, out);
    case Compression::bz2: return unpack_bz2(packed, size, out);
    case Compression::deflate: return unpack_deflate(packed, size, out, "deflate", -MAX_WBITS);
  }
}

void decompress_beginning(ByteCursor packed, std::uint64_t size, std::vector<std::uint8_t>& out) {
  unpack_deflate(packed, size, out, "deflate", -MAX_WBITS, size);
}

void decompress_zlib(ByteCursor packed, std::vector<std::uint8_t>& out) {
  unpack_deflate(packed, kUnknown, out, "zlib", MAX_WBITS);
}

}  // namespace credence::internal
