// Help: what CLI11 knows of commands and options, in words and in columns.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/terminal.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class CommandTree : public TerminalTest {};

TEST_F(CommandTree, AnOptionIsToldInWordsNotInTheSignsOfTheLibrary) {
  const std::string help = run({"help", "run"}).out;
  for (const char* entry :
       {"\n  scenario                scenario files, or names of credence list scenarios\n",
        "\n  --set KEY=VALUE         override a setting: section.key=value (repeatable)\n",
        "\n  --threads N             worker threads; 0: one for each processor; from 0 to 4096 (default 0)\n",
        "\n  --format text|json|latex\n                          what is printed on stdout (default text)\n",
        "\n  --quiet                 no progress on stderr\n", "\n  -h, --help              this help\n",
        // What leaves no room before its column has a line of its own, and what is long goes on in the
        // column.
        "\n  --log-format csv|npz|mcap\n                          of --log; npz: ",
        "\n  --fail-on-inconsistent  exit with 1 when a verdict is optimistic, pessimistic or mixed; "
        "undecided\n"
        "                          is no failure\n"}) {
    EXPECT_THAT(help, HasSubstr(entry));
  }
  EXPECT_THAT(run({"help", "list"}).out,
              HasSubstr("\n  what                    only these; one of scenarios, worlds, "
                        "commands\n"))
      << "many words stand with the others";
  EXPECT_THAT(run({"help", "replay"}).out, HasSubstr("from 1 to 5 (default 1)\n"));
  EXPECT_THAT(run({"help", "timing"}).out, HasSubstr("from 1 to 1000 (default 1,10)\n"));
}

TEST_F(CommandTree, CommandsStandUnderTheirHeadingsInTheOrderOfTheProgram) {
  std::istringstream lines(run({"help"}).out);
  std::vector<std::string> headings, of_looking;
  for (std::string line; std::getline(lines, line) && line != "Examples:";) {
    if (line.ends_with(':') && line != "Options:") headings.push_back(line);
    if (!headings.empty() && headings.back() == "Look at results:" && line.starts_with("  "))
      of_looking.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  EXPECT_EQ(headings, (std::vector<std::string>{"Simulate and judge:", "Judge what others wrote:",
                                                "Look at results:", "Theory and calibration:", "Begin:"}));
  EXPECT_EQ(of_looking, (std::vector<std::string>{"show", "compare", "report", "merge", "index"}));
}

TEST_F(CommandTree, HelpIsBrokenWhereTheTerminalEnds) {
  const auto widest = [](const std::string& text) {
    std::istringstream lines(
        text.substr(text.find("Options:"), text.find("Examples:") - text.find("Options:")));
    std::size_t most = 0;
    for (std::string line; std::getline(lines, line);) most = std::max(most, columns_of(line));
    return most;
  };
  EXPECT_LE(widest(on_terminal(60, "help plan")), 60U);
  EXPECT_GT(widest(run({"help", "plan"}).out), 60U);
  // Never wider than one reads with ease, and no narrower than a column of words.
  EXPECT_EQ(on_terminal(300, "help plan"), run({"help", "plan"}).out);
  EXPECT_EQ(on_terminal(10, "help plan"), on_terminal(40, "help plan"));
}

}  // namespace
}  // namespace credence::internal
