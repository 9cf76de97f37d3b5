#include <gmock/gmock.h>

#include <cstdlib>
#include <string>

#include "app/completion.h"
#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class ManPage : public CommandTest {};

TEST_F(ManPage, HasEveryCommandAndCode) {
  const std::string page = run({"help", "--man"}).out;
  EXPECT_THAT(page, ::testing::StartsWith(".TH CREDENCE 1 "));
  const Json commands = json({"list", "commands", "--format", "json"})["commands"];
  for (const auto& command : commands) {
    EXPECT_THAT(page, HasSubstr("\n.SS credence " + command["name"].get<std::string>()));
  }
  EXPECT_THAT(page, HasSubstr("\n.SS credence run scenario..."));
  EXPECT_THAT(page, HasSubstr(".TP\n130\ninterrupted"));
}

TEST_F(ManPage, NoLineOfTextIsACommandOfRoff) {
  // Of all that begins with a dot, only these are meant: a text such as ".toml" would vanish from the page.
  std::istringstream lines(run({"help", "--man"}).out);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_FALSE(line.starts_with('\'')) << line;
    if (!line.starts_with('.')) continue;
    const std::string request = line.substr(0, line.find(' '));
    EXPECT_THAT(request, ::testing::AnyOf(".TH", ".SH", ".SS", ".TP", ".PP", ".nf", ".fi", ".B", ".I"))
        << line;
  }
}

TEST_F(ManPage, OptionsKeepTheirDashes) {
  // A bare - is a hyphen, which nobody finds with a search for --out.
  const std::string page = run({"help", "--man"}).out;
  EXPECT_THAT(page, HasSubstr("\\fB\\-\\-out\\fR \\fIDIR\\fR"));
  EXPECT_EQ(page.find("--"), std::string::npos);
  EXPECT_THAT(page, HasSubstr("\\fB\\-\\-python\\fR")) << "of a group of options, too";
}

TEST_F(ManPage, GroffHasNothingToSay) {
  if (std::system("groff -v > /dev/null 2>&1") != 0) GTEST_SKIP() << "no groff";
  write("credence.1", run({"help", "--man"}).out);
  const std::string groff = "cd " + folder_.path().string() + " && groff -man -ww -z -K utf8 credence.1 ";
  EXPECT_EQ(std::system((groff + "2> said").c_str()), 0);
  EXPECT_EQ(read("said"), "");
}

// No text of the program begins so yet; roff would take it for a command and leave it out.
TEST(ManPageText, ALineThatBeginsWithADotOrAQuoteIsText) {
  const CommandShape command{
      .name = "run",
      .about = ".toml files are run",
      .group = "",
      .footer = "Examples:\n.hidden\n'quoted'\nplain.",
      .options = {{.names = {"--out"}, .value = "DIR", .about = "'x' or .x\\y", .choices = {}}}};
  const std::string page = man_page({&command, 1});
  for (const char* line : {"\n\\&.toml files are run\n", "\n\\&.hidden\n", "\n\\&'quoted'\n", "\nplain.\n",
                           "\n\\&'x' or .x\\ey\n"}) {
    EXPECT_THAT(page, HasSubstr(line));
  }
}

}  // namespace
}  // namespace credence::internal
