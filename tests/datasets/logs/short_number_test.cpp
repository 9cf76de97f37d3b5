#include "datasets/logs/short_number.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <string>

#include "tests/datasets/logs/number_texts.h"

namespace credence::internal {
namespace {

/// Whether the text is read as a short number; then, whatever stands behind it, as std::from_chars reads it.
bool expect_as_by_the_library(std::string text) {
  const std::size_t length = text.size();
  bool any = false;
  for (const char* behind : {",1,2,3", "\n", "0123456789", ".5e3", "e5"}) {
    text.resize(length);
    text += behind;
    text.resize(length + static_cast<std::size_t>(kReadBeyond), '7');
    const char *const first = text.data(), *const last = first + length;
    double expected = -7.0, read = -7.0;
    const char* const end = read_short_number(first, last, read);
    if (end == nullptr) continue;
    any = true;
    const auto [stop, error] = std::from_chars(first, last, expected);
    EXPECT_EQ(error, std::errc()) << text;
    EXPECT_EQ(end - first, stop - first) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(read), std::bit_cast<std::uint64_t>(expected)) << text;
  }
  return any;
}

TEST(ShortNumber, IsReadAsByTheLibrary) {
  for (const char* text :
       {"0", "-0", "1", "-1.5", "007.250", ".5", "5.", "-.5", "1e5", "1E-5", "1e+05", "1e22",
        "9007199254740992", "12345678", "1234567.8", "0.12345678", "1700000000.123456"})
    EXPECT_TRUE(expect_as_by_the_library(text)) << text;
  for (const char* text : {".",
                           "-",
                           "",
                           "+1",
                           "1e",
                           "1e+",
                           "1e-",
                           "1e+-5",
                           "1e23",
                           "1e-23",
                           "9007199254740993",
                           "1e-400",
                           "1e400",
                           "1e99999999999",
                           "123456789012345678",
                           "99999999999999999999",
                           "0.9007199254740993",
                           "0.12345678123456781",
                           "0.00000000000000000001",
                           "nan",
                           "inf",
                           "e5"})
    EXPECT_FALSE(expect_as_by_the_library(text)) << text;
  for (const char* text : {"1..2", "1,2", "0x10", "1.5e-12x", "-1-1"}) expect_as_by_the_library(text);
  for (const std::string& text : testing::number_texts()) expect_as_by_the_library(text);
}

}  // namespace
}  // namespace credence::internal
