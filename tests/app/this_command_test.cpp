// The command line that a report shows, as one would type it again.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "app/shell_word.h"
#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class ThisCommand : public CommandTest {};

TEST_F(ThisCommand, IsTheNameOfTheProgramAndEveryWordAsAShellTakesIt) {
  write("it's a.toml", kMonobot);
  ASSERT_EQ(
      run({"run", "it's a.toml", "--set", "study.stop.verdict=\"either\"", "--runs", "64", "--out", "o-1"})
          .code,
      0);
  // A quote is written behind the end of the quoted, which begins again.
  const std::string typed =
      "credence run 'it'\\''s a.toml' --set 'study.stop.verdict=\"either\"' --runs 64 --out o-1";
  std::string in_html;
  for (const char c : typed) in_html += c == '\'' ? "&#39;" : c == '"' ? "&quot;" : std::string(1, c);
  EXPECT_THAT(read("o-1/index.html"), HasSubstr("name=\"credence-command\" content=\"" + in_html + "\""));

  // And so does a shell understand it.
  write("again", "PATH=" + credence_binary().parent_path().string() + ":$PATH\nset -- " + typed +
                     "\nshift; for word; do printf '<%s>' \"$word\"; done");
  EXPECT_EQ(finish(start_program({"sh", "again"})).out,
            "<run><it's a.toml><--set><study.stop.verdict=\"either\"><--runs><64><--out><o-1>");
}

TEST_F(ThisCommand, OfAnEmptyWordIsSeen) { EXPECT_EQ(shell_word(""), "''"); }

}  // namespace
}  // namespace credence::internal
