#pragma once

#include <cstdint>
#include <vector>

#include "datasets/logs/bytes/byte_cursor.h"

namespace credence::internal {

enum class Compression { none, lz4, zstd, bz2, deflate };

/// Unpacks what is left of `packed` into `out`: lz4 and zstd frames, bz2, and deflate without a header (as in
/// a zip file).
///
/// size: what the container says it unpacks to; it must be met exactly. Memory grows with what comes out, so
/// a false size costs none, and zstd takes a window of 128 MiB at most beside it. Throws DataError at the
/// packed bytes for a false size, one above 1 GiB, a wider window, and for bytes that cannot be unpacked.
void decompress(Compression compression, ByteCursor packed, std::uint64_t size,
                std::vector<std::uint8_t>& out);

/// The first `size` bytes of a deflate stream without a header. Throws DataError as decompress, where there
/// are fewer.
void decompress_beginning(ByteCursor packed, std::uint64_t size, std::vector<std::uint8_t>& out);

/// Unpacks a zlib stream whose size nobody says, up to 1 GiB. Throws DataError as decompress.
void decompress_zlib(ByteCursor packed, std::vector<std::uint8_t>& out);

}  // namespace credence::internal
