#include "montecarlo/engine/packed_bytes.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <span>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

void expect_more_than_it_can_hold(std::span<const std::byte> frame) {
  try {
    unpacked(frame);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), "more than its frame can hold");
  }
}

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
  expect_more_than_it_can_hold(frame);
}

// A large frame, too: the heads of its blocks say what is in them.
TEST(PackedBytes, a_damaged_size_is_seen_before_anything_is_allocated) {
  std::mt19937_64 random(1);
  std::vector<std::byte> bytes(1'000'000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % 16);  // packed by half
  std::vector<std::byte> frame = packed(bytes);
  EXPECT_EQ(unpacked(frame), bytes);
  constexpr std::size_t kThirdByteOfSize = 4 + 1 + 1 + 2;  // magic, descriptor, window, of four bytes
  frame[kThirdByteOfSize] ^= std::byte{0x10};              // one million and another
  expect_more_than_it_can_hold(frame);
}

TEST(PackedBytes, frames_of_every_kind_of_block_come_back) {
  std::mt19937_64 random(2);
  for (const std::size_t size : {255U, 256U, 70'000U, 131'072U, 131'073U, 500'000U}) {
    for (const unsigned kinds : {1U, 2U, 16U, 256U}) {
      std::vector<std::byte> bytes(size);
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % kinds);
      EXPECT_EQ(unpacked(packed(bytes)), bytes) << size << " of " << kinds;
    }
  }
}

// The head of a frame at every length, and with every one of its bits turned, is refused or read.
TEST(PackedBytes, a_damaged_frame_is_never_read_past_its_end) {
  const std::vector<std::byte> frame = packed(std::vector<std::byte>(300, std::byte{7}));
  for (std::size_t size = 0; size < frame.size(); ++size)
    EXPECT_THROW(unpacked(std::span(frame).first(size)), std::runtime_error) << size;
  for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
    std::vector<std::byte> damaged = frame;
    damaged[bit / 8] ^= std::byte{1} << (bit % 8);
    try {
      EXPECT_LE(unpacked(damaged).size(), std::size_t{1} << 17U) << bit;
    } catch (const std::runtime_error&) {
      continue;
    }
  }
}

}  // namespace
}  // namespace credence::internal
