#include "datasets/logs/bytes/decompress.h"

#include <gmock/gmock.h>
#include <zlib.h>
#include <zstd.h>

#include <memory>

#include "datasets/data_error.h"
#include "tests/datasets/logs/ros/ros_writers.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using testing::Packing;
using ::testing::ThrowsMessage;

const ByteOrigin kOrigin{"log.bin", ""};

ByteCursor cursor(const std::string& bytes) {
  return {Bytes(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()), kOrigin, 0};
}

/// Longer than the first output that is made room for.
std::string text() {
  std::string text;
  for (int i = 0; i < 30'000; ++i) text += std::to_string(i * i % 977);
  return text;
}

TEST(Decompress, WhatWasPackedComesBack) {
  const std::pair<Compression, Packing> cases[] = {{Compression::none, Packing::none},
                                                   {Compression::lz4, Packing::lz4},
                                                   {Compression::zstd, Packing::zstd},
                                                   {Compression::bz2, Packing::bz2}};
  for (const auto& [compression, packing] : cases) {
    const std::string packed = testing::packed(text(), packing);
    std::vector<std::uint8_t> out;
    decompress(compression, cursor(packed), text().size(), out);
    EXPECT_EQ(std::string(out.begin(), out.end()), text());
    // A size that is false, of either sign, is told; so is a stream that is cut off.
    EXPECT_THROW(decompress(compression, cursor(packed), text().size() - 1, out), DataError);
    EXPECT_THROW(decompress(compression, cursor(packed), text().size() + 1, out), DataError);
    EXPECT_THROW(decompress(compression, cursor(packed.substr(0, packed.size() / 2)), text().size(), out),
                 DataError);
  }
}

TEST(Decompress, AFalseSizeCostsNoMemory) {
  std::vector<std::uint8_t> out;
  const std::string packed = testing::packed("short", Packing::lz4);
  EXPECT_THAT([&] { decompress(Compression::lz4, cursor(packed), std::uint64_t{1} << 30, out); },
              ThrowsMessage<DataError>(HasSubstr("lz4 unpacks to 5 bytes, not to 1073741824")));
  EXPECT_LT(out.capacity(), std::size_t{1} << 20);
  EXPECT_THAT([&] { decompress(Compression::lz4, cursor(packed), (std::uint64_t{1} << 30) + 1, out); },
              ThrowsMessage<DataError>(HasSubstr("at most 1 GiB")));
}

/// As `zstd --long=LOG` packs what comes in a pipe: how long it is, it does not know.
std::string packed_with_window(const std::string& bytes, int log) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_enableLongDistanceMatching, 1);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, log);
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  ZSTD_inBuffer from{bytes.data(), bytes.size(), 0};
  ZSTD_outBuffer to{out.data(), out.size(), 0};
  ZSTD_compressStream2(context.get(), &to, &from, ZSTD_e_continue);
  EXPECT_EQ(ZSTD_compressStream2(context.get(), &to, &from, ZSTD_e_end), 0U);
  return out.substr(0, to.pos);
}

TEST(Decompress, AWindowOfZstdIsAsWideAsZstdItselfReads) {
  std::vector<std::uint8_t> out;
  const std::string widest = packed_with_window(text(), 27);
  decompress(Compression::zstd, cursor(widest), text().size(), out);
  EXPECT_EQ(std::string(out.begin(), out.end()), text());
  const std::string wider = packed_with_window(text(), 28);
  EXPECT_THAT([&] { decompress(Compression::zstd, cursor(wider), text().size(), out); },
              ThrowsMessage<DataError>("log.bin:byte 0: zstd with a window of more than 128 MiB: `mcap "
                                       "decompress` makes a copy that is not packed"));
}

TEST(Decompress, AZlibStreamNeedsNoSize) {
  std::string packed(compressBound(text().size()), '\0');
  uLongf size = packed.size();
  const std::string plain = text();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(plain.data()),
           plain.size());
  packed.resize(size);
  std::vector<std::uint8_t> out;
  decompress_zlib(cursor(packed), out);
  EXPECT_EQ(std::string(out.begin(), out.end()), plain);
  EXPECT_THROW(decompress_zlib(cursor(packed.substr(0, 50)), out), DataError);
}

}  // namespace
}  // namespace credence::internal
