#include "core/utf8.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(Utf8, CodePointsSurviveEncodingAndDecoding) {
  for (const char32_t c : {U'a', U'²', U'−', U'😀', char32_t{0x7FF}, char32_t{0x800}, char32_t{0xFFFD}}) {
    std::string bytes;
    append_utf8(bytes, c);
    std::size_t position = 0;
    EXPECT_EQ(next_code_point(bytes, position), c);
    EXPECT_EQ(position, bytes.size());
  }
}

TEST(Utf8, WhatIsNoCodePointIsReplaced) {
  for (const char32_t c : {char32_t{0xD800}, char32_t{0xDFFF}, char32_t{0x110000}}) {
    std::string bytes;
    append_utf8(bytes, c);
    EXPECT_EQ(bytes, "\uFFFD");
  }
}

TEST(Utf8, TextIsCutBetweenCodePoints) {
  const std::string_view text = "aé😀";  // of 1, 2 and 4 bytes
  EXPECT_EQ(beginning_of_text(text, 7), text);
  for (const std::size_t longest : {3U, 4U, 5U, 6U}) EXPECT_EQ(beginning_of_text(text, longest), "aé");
  for (const std::size_t longest : {1U, 2U}) EXPECT_EQ(beginning_of_text(text, longest), "a");
  EXPECT_EQ(beginning_of_text(text, 0), "");
  EXPECT_EQ(beginning_of_text("\x80\x80", 1), "") << "no text";
}

}  // namespace
}  // namespace credence::internal
