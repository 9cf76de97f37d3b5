#include "reports/render/utf8_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace credence::internal {
namespace {

TEST(Utf8Text, CountsColumnsAndNotBytes) {
  EXPECT_EQ(display_width(""), 0u);
  EXPECT_EQ(display_width("trace"), 5u);
  EXPECT_EQ(display_width("σ² × −1"), 7u);
  EXPECT_EQ(display_width("e\u0301"), 1u) << "a combining accent takes no column";
  EXPECT_EQ(display_width("日本"), 4u);
}

TEST(Utf8Text, LinesBreakBetweenWords) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(wrapped_lines("σ² of the position", 9), (Lines{"σ² of the", "position"}));
  EXPECT_EQ(wrapped_lines("an autocorrelation", 5), (Lines{"an", "autocorrelation"}));
  EXPECT_EQ(wrapped_lines("", 5), Lines{""});
}

TEST(Utf8Text, KeepsGoodText) {
  EXPECT_EQ(printable_line("2σ bounds, K₁ – 日本 😀"), "2σ bounds, K₁ – 日本 😀");
}

TEST(Utf8Text, ControlCharactersBecomeSpaces) {
  EXPECT_EQ(printable_line("a\nb\tc\x1b[31md"), "a b c [31md");
  EXPECT_EQ(printable_line(std::string_view("a\0b", 3)), "a b");
  EXPECT_EQ(printable_line("a\u0085b\u2028c"), "a b c");
}

TEST(Utf8Text, AJsonDocumentIsTheSameWithoutWhatATerminalObeysOrHides) {
  const std::string plain = "{\n \"name\": \"Höhe ψ\"\n}";
  EXPECT_EQ(printable_json(plain), plain);
  const std::string hostile = "{\"a\xC2\x9B\": \"\x7F\xE2\x80\xAEü\"}", shown = printable_json(hostile);
  EXPECT_EQ(shown, "{\"a\\u009b\": \"\\u007f\\u202eü\"}");
  EXPECT_EQ(nlohmann::json::parse(shown), nlohmann::json::parse(hostile));
}

TEST(Utf8Text, InvalidBytesBecomeReplacementCharacters) {
  EXPECT_EQ(printable_line("a\xff"), "a\uFFFD");
  EXPECT_EQ(printable_line("\xc0\xaf"), "\uFFFD\uFFFD") << "overlong slash";
  EXPECT_EQ(printable_line("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "surrogate";
  EXPECT_EQ(printable_line("\xe2\x88"), "\uFFFD\uFFFD") << "cut within a character";
  EXPECT_EQ(printable_line("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD") << "beyond the last code point";
}

TEST(Utf8Text, DropsWhatHidesOrReorders) {
  EXPECT_EQ(printable_line("a\u202Eb\u200Bc\uE026d\uFEFF"), "abcd");
}

}  // namespace
}  // namespace credence::internal
