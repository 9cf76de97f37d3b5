#include "datasets/logs/bytes/byte_cursor.h"

#include <gmock/gmock.h>

#include <array>

#include "datasets/data_error.h"
#include "datasets/logs/bytes/binary_file.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const ByteOrigin kFile{"flight.bin", ""}, kChunk{"flight.bin", "the chunk at byte 9"};
constexpr std::array<std::uint8_t, 8> kBytes = {1, 2, 3, 4, 5, 6, 7, 8};

TEST(ByteCursor, ReadsNumbersOfEitherOrderAtAnyAlignment) {
  ByteCursor little(kBytes, kFile, 0);
  EXPECT_EQ(little.take<std::uint8_t>(), 1);
  EXPECT_EQ(little.take<std::uint32_t>(), 0x05040302U);
  little.set_order(std::endian::big);
  EXPECT_EQ(little.take<std::uint16_t>(), 0x0607);
  EXPECT_EQ(little.left(), 1U);
}

TEST(ByteCursor, WhatDoesNotFitIsAnErrorWithThePlace) {
  ByteCursor cursor(kBytes, kFile, 100);
  cursor.skip(3);
  EXPECT_THAT(
      [&] { cursor.take<double>(); },
      ThrowsMessage<DataError>("flight.bin:byte 103: 8 bytes are needed here and 5 are left: cut off, or "
                               "corrupted"));
  EXPECT_EQ(cursor.left(), 5U);  // nothing was taken
  // A count near 2⁶⁴ does not wrap around.
  EXPECT_THAT([&] { cursor.take_bytes(~std::uint64_t{0}); }, ThrowsMessage<DataError>(HasSubstr("byte 103")));
  ByteCursor inside(kBytes, kChunk, 2);
  EXPECT_THAT([&] { inside.fail("is odd"); },
              ThrowsMessage<DataError>("flight.bin:byte 2 of the chunk at byte 9: is odd"));
}

TEST(ByteCursor, APartEndsWhereItWasSaidTo) {
  ByteCursor cursor(kBytes, kFile, 10);
  ByteCursor part = cursor.part(2);
  EXPECT_EQ(cursor.position(), 12U);
  EXPECT_EQ(part.take<std::uint16_t>(), 0x0201);
  EXPECT_TRUE(part.done());
  EXPECT_THROW(part.take<std::uint8_t>(), DataError);
}

TEST(BinaryFile, ViewsAreCheckedAgainstTheFile) {
  const TemporaryFolder folder;
  BinaryFile file(folder.write("a.bin", "0123456789"));
  EXPECT_EQ(file.view(7, 3, "a record")[2], '9');
  EXPECT_EQ(file.view(0, 1, "a record")[0], '0');
  EXPECT_EQ(file.view(10, 0, "a record").size(), 0U);
  EXPECT_THAT([&] { file.view(8, 3, "a record"); },
              ThrowsMessage<DataError>(
                  HasSubstr("byte 8: a record of 3 bytes begins here and the file ends at byte 10")));
  EXPECT_THROW(file.view(11, 0, "a record"), DataError);
  EXPECT_THROW(file.view(1, ~std::uint64_t{0}, "a record"), DataError);
  EXPECT_THROW(BinaryFile(folder / "absent"), DataError);
  EXPECT_THROW(BinaryFile(folder.path()), DataError);
}

}  // namespace
}  // namespace credence::internal
