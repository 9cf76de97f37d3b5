#include "montecarlo/engine/packed_bytes.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

TEST(PackedBytes, come_back) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{20'000'000}}) {
    const std::vector<std::byte> zeros(size);  // as small a frame as there is
    EXPECT_EQ(unpacked(packed(zeros)), zeros);
  }
}

// Content size 900,000,000 and an empty last block: nothing may be allocated for it.
TEST(PackedBytes, a_small_frame_that_claims_a_gigabyte_is_refused) {
  std::vector<std::byte> frame;
  for (const int byte : {0x28, 0xb5, 0x2f, 0xfd, 0xe0, 0x00, 0xe9, 0xa4, 0x35, 0, 0, 0, 0, 1, 0, 0}) {
    frame.push_back(static_cast<std::byte>(byte));
  }
  try {
    unpacked(frame);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), "more than its frame can hold");
  }
}

}  // namespace
}  // namespace credence::internal
