#include "core/control_characters.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(ControlCharacters, AreFoundInWhateverNotationATerminalObeys) {
  for (const char* text :
       {"a\nb", "\x1b[31m", "\x7f", "\xC2\x80", "x\xC2\x9B", "\xE2\x80\xA8", "\xE2\x80\xA9x"}) {
    EXPECT_TRUE(has_control_character(text)) << text;
  }
  EXPECT_TRUE(has_control_character(std::string_view("\0", 1)));
}

TEST(ControlCharacters, AreNotSeenWhereThereAreNone) {
  for (const char* text : {"", "x y", "pose.x:angle", "Höhe", "\xC2\xA0", "ψ₁", "\xE2\x80\xA7", "\xE2\x80",
                           "\xC2", "\x9B", "\xFF"}) {
    EXPECT_FALSE(has_control_character(text)) << text;
  }
}

}  // namespace
}  // namespace credence::internal
