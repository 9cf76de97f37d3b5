#include "datasets/logs/bytes/append_crc32.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

// The check value of CRC-32/ISO-HDLC: 0xCBF43926 for "123456789".
TEST(AppendCrc32, HasTheCheckValueInLittleEndian) {
  std::string bytes = "x";
  append_crc32(bytes, "123456789");
  EXPECT_EQ(bytes, "x\x26\x39\xF4\xCB");
}

}  // namespace
}  // namespace credence::internal
