#include "datasets/logs/short_fields.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/logs/short_number.h"
#include "tests/datasets/logs/number_texts.h"

namespace credence::internal {
namespace {

/// Expects that what is read of the field, in the middle of a line and at its end, is what the library reads;
/// whether it is read.
bool expect_as_by_library(const std::string& field) {
  double expected = -7.0;
  const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), expected);
  const bool number = error == std::errc() && stop == field.data() + field.size();
  bool any = false;
  for (const char* behind : {",77", "\n", "\r\n", "\n,5", "\n.5", "\n4"}) {
    std::string text = field + behind;
    const std::size_t length = text.find_first_of("\r\n");
    const std::size_t end = length == std::string::npos ? text.size() : length;
    if (length == std::string::npos) text += '\n';
    text.resize(text.size() + static_cast<std::size_t>(kReadBeyond), '7');
    std::vector<double> read(3, -7.0);
    std::size_t count = 0;
    const char* const line_end = text.data() + end;
    const char* const at = read_short_fields(text.data(), line_end, read, count);
    if (count == 0) {
      EXPECT_EQ(at, text.data()) << field;
      continue;
    }
    any = true;
    EXPECT_TRUE(number) << field;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(read[0]), std::bit_cast<std::uint64_t>(expected)) << field;
    EXPECT_EQ(at, line_end + 1) << field << behind;
    EXPECT_EQ(count, *behind == ',' ? 2U : 1U) << field;
  }
  return any;
}

bool can_read() {
  const std::string text = "1\n" + std::string(kReadBeyond, '7');
  std::vector<double> read(1);
  std::size_t count = 0;
  read_short_fields(text.data(), text.data() + 1, read, count);
  return count == 1;
}

TEST(ShortFields, AreReadAsByTheLibrary) {
  for (const char* text : {"0", "-0", "1", "-1.5", "007.250", ".5", "5.", "-.5", "1e5", "1E-5", "1e22",
                           "-0e0", "0.00", "123456789012345", "-12345678901234.", "1234567.1234567",
                           "0.0000000000001", "1.5e-12", "123456789012345e-22"})
    EXPECT_EQ(expect_as_by_library(text), can_read()) << text;
  for (const char* text : {"",
                           "-",
                           ".",
                           "-.",
                           "+1",
                           "--1",
                           "1..2",
                           "1.2.3",
                           "1e",
                           "1e+",
                           "1e-",
                           "1e+-5",
                           "1e23",
                           "1e-23",
                           "1e400",
                           "1e005",
                           "1234567890123456",
                           "0.12345678901234",
                           "nan",
                           "inf",
                           "e5",
                           " 1",
                           "1 ",
                           "\"1\"",
                           "0x10",
                           "1-1",
                           "1e5e5",
                           "1e5.5",
                           "1:2",
                           "1/2"})
    EXPECT_FALSE(expect_as_by_library(text)) << text;
  for (const std::string& text : testing::number_texts()) expect_as_by_library(text);
}

TEST(ShortFields, StopWhereThereIsNoRoomAndAtWhatIsLeftToOthers) {
  if (!can_read()) GTEST_SKIP() << "not with this processor";
  const std::string line = "1,-2.5,,4";
  const std::string text = line + '\n' + std::string(kReadBeyond, '7');
  const char* const line_end = text.data() + line.size();
  std::vector<double> read(4, 0.0);
  std::size_t count = 0;
  EXPECT_EQ(read_short_fields(text.data(), line_end, read, count), text.data() + 7);
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(read[1], -2.5);
  count = 3;
  EXPECT_EQ(read_short_fields(text.data() + 8, line_end, read, count), line_end + 1);
  EXPECT_EQ(read[3], 4.0);
  count = 3;
  EXPECT_EQ(read_short_fields(text.data(), line_end, read, count), text.data() + 2);
  EXPECT_EQ(count, 4U);
}

}  // namespace
}  // namespace credence::internal
