#include "montecarlo/scenario/leading_comment.h"

#include <gtest/gtest.h>

#include <sstream>

namespace credence::internal {
namespace {

std::string comment_of(const std::string& scenario) {
  std::istringstream text(scenario);
  return leading_comment(text);
}

TEST(LeadingComment, IsTheFirstParagraphOfComment) {
  EXPECT_EQ(comment_of("# Figure 2:\n#   P grows.\n#\n# More.\n[world]\n# not this\n"), "Figure 2: P grows.");
}

TEST(LeadingComment, IsCutBetweenLetters) {
  std::string long_one = "a";
  for (int i = 0; i < 1500; ++i) long_one += "é";
  EXPECT_EQ(comment_of("# " + long_one + "\n"), long_one.substr(0, 1999));
}

TEST(LeadingComment, IsEmptyWhereThereIsNone) {
  EXPECT_EQ(comment_of("[world]\n# late\n"), "");
  EXPECT_EQ(comment_of(""), "");
}

}  // namespace
}  // namespace credence::internal
