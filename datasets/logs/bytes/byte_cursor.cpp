#include "datasets/logs/bytes/byte_cursor.h"

#include <fmt/format.h>

#include "datasets/data_error.h"

namespace credence::internal {

void ByteCursor::fail_at(std::uint64_t position, const std::string& problem) const {
  const std::string& inside = origin_->inside;
  throw DataError(origin_->file, fmt::format("byte {}{}{}", position, inside.empty() ? "" : " of ", inside),
                  problem);
}

void ByteCursor::fail_short(std::uint64_t count) const {
  fail(fmt::format("{} bytes are needed here and {} are left: cut off, or corrupted", count, left()));
}

}  // namespace credence::internal
