#include "montecarlo/scenario/leading_comment.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace credence {
namespace {

TEST(LeadingComment, IsTheFirstParagraphOfComment) {
  const TemporaryFolder folder;
  folder.write("a.toml", "# Figure 2:\n#   P grows.\n#\n# More.\n[world]\n# not this\n");
  EXPECT_EQ(leading_comment(folder / "a.toml"), "Figure 2: P grows.");
}

TEST(LeadingComment, IsEmptyWhereThereIsNone) {
  const TemporaryFolder folder;
  folder.write("a.toml", "[world]\n# late\n");
  EXPECT_EQ(leading_comment(folder / "a.toml"), "");
  EXPECT_EQ(leading_comment(folder / "no such file"), "");
}

}  // namespace
}  // namespace credence
