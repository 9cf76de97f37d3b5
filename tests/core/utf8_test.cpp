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

}  // namespace
}  // namespace credence::internal
