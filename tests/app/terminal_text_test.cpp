// Results on a terminal: colours, and lines as wide as it is.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <string>

#include "tests/app/small_studies.h"
#include "tests/app/terminal.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class TerminalText : public TerminalTest {};

std::size_t widest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t widest = 0;
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, columns_of(line));
  return widest;
}

TEST_F(TerminalText, HasColoursWhereNobodyMinds) {
  write("a.toml", kMonobot);
  const std::string run_a = "run a.toml --quiet", coloured = "\x1b[32mconsistent\x1b[0m";
  EXPECT_THAT(on_terminal(200, run_a), HasSubstr(coloured));
  EXPECT_THAT(on_terminal(200, run_a, "NO_COLOR= TERM=xterm"), HasSubstr(coloured))
      << "empty is no wish (no-color.org)";
  for (const char* environment :
       {"NO_COLOR=1 TERM=xterm", "NO_COLOR=0 TERM=xterm", "-u NO_COLOR TERM=dumb"}) {
    EXPECT_THAT(on_terminal(200, run_a, environment), Not(HasSubstr("\x1b"))) << environment;
  }
  EXPECT_THAT(run({"run", "a.toml"}).out, Not(HasSubstr("\x1b"))) << "a file";
}

TEST_F(TerminalText, OfAWideTerminalIsThatOfAFileButForColours) {
  write("a.toml", kMonobot);
  const std::string text = on_terminal(1000, "run a.toml --quiet");
  EXPECT_EQ(std::regex_replace(text, std::regex("\x1b\\[[0-9;]*m"), ""), run({"run", "a.toml"}).out);
}

TEST_F(TerminalText, TablesAreNoWiderThanTheTerminal) {
  const std::string file = run({"list", "worlds"}).out;
  ASSERT_GT(widest_line(file), 60U) << "else there is nothing to break";
  const std::string narrow = on_terminal(60, "list worlds");
  EXPECT_LE(widest_line(narrow), 60U) << narrow;
  EXPECT_GT(std::ranges::count(narrow, '\n'), std::ranges::count(file, '\n'));
}

}  // namespace
}  // namespace credence::internal
