#include "datasets/logs/bytes/binary_file.h"

#include <gmock/gmock.h>

#include <limits>

#include "datasets/data_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

constexpr std::uint64_t kMegabyte = std::uint64_t{1} << 20;

std::string text_of(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// A file whose bytes tell where they are.
std::string numbered_bytes(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i % 251);
  return bytes;
}

TEST(BinaryFile, views_are_the_bytes_of_the_file_in_any_order) {
  const TemporaryFolder folder;
  const std::string bytes = numbered_bytes(3 * kMegabyte + 17);
  BinaryFile file(folder.write("log", bytes));
  EXPECT_EQ(file.size(), bytes.size());
  for (const auto& [at, count] :
       std::vector<std::pair<std::uint64_t, std::uint64_t>>{{0, 4},
                                                            {kMegabyte - 1, 2},
                                                            {kMegabyte - 2, 4},
                                                            {5, 10},
                                                            {3 * kMegabyte, 17},
                                                            {1, 2 * kMegabyte},
                                                            {0, bytes.size()},
                                                            {kMegabyte, 1},
                                                            {bytes.size() - 1, 1}}) {
    EXPECT_EQ(text_of(file.view(at, count, "a part")), bytes.substr(at, count)) << at << ' ' << count;
  }
}

TEST(BinaryFile, nothing_may_be_asked_for_up_to_the_end) {
  const TemporaryFolder folder;
  BinaryFile file(folder.write("log", "abc")), empty(folder.write("empty", ""));
  EXPECT_EQ(file.view(3, 0, "nothing").size(), 0U);
  EXPECT_EQ(file.view(1, 0, "nothing").size(), 0U);
  EXPECT_EQ(empty.view(0, 0, "nothing").size(), 0U);
  EXPECT_EQ(text_of(file.view(0, 3, "all")), "abc");
  EXPECT_THROW(file.view(4, 0, "nothing"), DataError);
}

TEST(BinaryFile, what_the_file_does_not_hold_is_an_error_with_the_byte_and_takes_no_memory) {
  const TemporaryFolder folder;
  BinaryFile file(folder.write("log", "abcdef"));
  const auto fails = [&](std::uint64_t at, std::uint64_t count, const std::string& problem) {
    EXPECT_THAT([&] { file.view(at, count, "a thing"); },
                ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
  };
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  fails(2, 5,
        "log:byte 2: a thing of 5 bytes begins here and the file ends at byte 6: cut off, or corrupted");
  fails(7, 1, "byte 7: a thing of 1 bytes");
  fails(0, kMost, "byte 0: a thing of 18446744073709551615 bytes");
  fails(2, kMost - 1, "byte 2: a thing of");
  fails(kMost, 2, "byte 18446744073709551615: a thing");
  EXPECT_EQ(text_of(file.view(5, 1, "a thing")), "f") << "and reads on";
}

TEST(BinaryFile, a_cursor_counts_from_where_it_begins) {
  const TemporaryFolder folder;
  BinaryFile file(folder.write("log", std::string("xx\x01\x02\x03", 5)));
  EXPECT_EQ(file.cursor(2, 2, "a number").take<std::uint16_t>(), 0x0201);
  EXPECT_EQ(file.cursor(2, 2, "a number", std::endian::big).take<std::uint16_t>(), 0x0102);
  ByteCursor cursor = file.cursor(2, 3, "numbers");
  cursor.skip(2);
  EXPECT_EQ(cursor.position(), 4U);
  EXPECT_THAT(
      [&] { cursor.take<std::uint32_t>(); },
      ::testing::ThrowsMessage<DataError>(HasSubstr("log:byte 4: 4 bytes are needed here and 1 are left")));
}

TEST(BinaryFile, a_file_that_became_shorter_cannot_be_read_until_it_is_whole_again) {
  const TemporaryFolder folder;
  const std::string whole = numbered_bytes(2 * kMegabyte);
  BinaryFile file(folder.write("log", whole));
  EXPECT_EQ(file.view(0, 1, "a byte")[0], 0);
  std::filesystem::resize_file(folder / "log", kMegabyte / 2);
  EXPECT_THAT([&] { file.view(kMegabyte / 4, kMegabyte, "a part"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("byte 262144: cannot be read")));
  folder.write("log", whole);
  EXPECT_EQ(file.view(0, 1, "a byte")[0], 0) << "not what was read in vain";
  EXPECT_EQ(file.view(10, 1, "a byte")[0], 10);
}

TEST(BinaryFile, what_is_no_file_is_named) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { BinaryFile(folder / "absent"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("absent: there is no such file")));
  EXPECT_THAT([&] { BinaryFile(folder.path()); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("is not a regular file")));
}

}  // namespace
}  // namespace credence::internal
