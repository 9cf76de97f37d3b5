#include "core/trim_blanks.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(TrimBlanks, AtTheEndsAlone) {
  EXPECT_EQ(trim_blanks(" \t a b\t "), "a b");
  EXPECT_EQ(trim_blanks("a"), "a");
  EXPECT_EQ(trim_blanks(" \t"), "");
  EXPECT_EQ(trim_blanks(""), "");
}

}  // namespace
}  // namespace credence::internal
