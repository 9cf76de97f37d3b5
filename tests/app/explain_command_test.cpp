#include <gmock/gmock.h>

#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class ExplainCommand : public CommandTest {};

TEST_F(ExplainCommand, AWordHasOneAnswerHoweverItIsSpelled) {
  const Finished nees = run({"explain", "NEES"});
  EXPECT_EQ(nees.code, 0);
  EXPECT_THAT(nees.out, ::testing::StartsWith("NEES: "));
  EXPECT_THAT(nees.out, HasSubstr("P⁻¹"));
  EXPECT_EQ(run({"explain", "nees"}).out, nees.out);
  const Finished factor = run({"explain", "factor", "on", "P"});
  EXPECT_THAT(factor.out, ::testing::StartsWith("factor on P: "));
  EXPECT_EQ(run({"explain", "factor on P"}).out, factor.out);
}

TEST_F(ExplainCommand, AloneItListsEveryWordAndEachIsExplained) {
  const Finished all = run({"explain"});
  EXPECT_EQ(all.code, 0);
  int words = 0;
  std::istringstream lines(all.out);
  for (std::string line; std::getline(lines, line); ++words) {
    const std::string word = line.substr(0, line.find("  "));
    EXPECT_THAT(run({"explain", word}).out, ::testing::StartsWith(word + ": ")) << line;
  }
  EXPECT_GT(words, 20);
}

TEST_F(ExplainCommand, AnUnknownWordGetsThoseThatAreNear) {
  const Finished near = run({"explain", "optimistc"});
  EXPECT_EQ(near.code, 2);
  EXPECT_EQ(near.out, "");
  EXPECT_EQ(near.err, "credence: \"optimistc\" is not explained; did you mean optimistic?\n");
  EXPECT_EQ(run({"explain", "xyzzyx"}).err,
            "credence: \"xyzzyx\" is not explained; credence explain alone lists all words\n");
  EXPECT_EQ(run({"explain", "\x1b[31mred"}).err.find('\x1b'), std::string::npos)
      << "no colour of the user's on the terminal";
}

}  // namespace
}  // namespace credence::internal
