#include <gmock/gmock.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class Completion : public CommandTest {
 protected:
  std::vector<std::string> commands() const {
    std::vector<std::string> names;
    const Json commands = json({"list", "commands", "--format", "json"})["commands"];
    for (const auto& command : commands) {
      names.push_back(command["name"]);
    }
    return names;
  }
};

/// The words of a line as fish reads it: within single quotes a backslash goes before \ and ' alone. Empty
/// where a quote stays open.
std::vector<std::string> words_of_fish(const std::string& line) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '\'') {
      quoted = !quoted;
    } else if (c == '\\' && i + 1 < line.size() && (!quoted || line[i + 1] == '\'' || line[i + 1] == '\\')) {
      words.back() += line[++i];
    } else if (c == ' ' && !quoted) {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  if (quoted) words.clear();
  return words;
}

TEST_F(Completion, OfFishIsWordsThatItReads) {
  const std::string text = run({"completion", "fish"}).out;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, ::testing::StartsWith("# "));
  while (std::getline(lines, line)) {
    const std::vector<std::string> words = words_of_fish(line);
    ASSERT_GT(words.size(), 5U) << line;
    EXPECT_EQ(words[0] + words[1] + words[2], "complete-ccredence");
    // Options and their values: nothing is left over that fish would take for a further word.
    for (std::size_t i = 3; i < words.size(); ++i) {
      const std::string& word = words[i];
      const bool flag = word == "-f" || word == "-r" || word == "-x";
      if (flag) continue;
      EXPECT_TRUE(word == "-n" || word == "-a" || word == "-d" || word == "-l") << word << " in: " << line;
      ++i;
    }
  }
  for (const std::string& command : commands()) {
    EXPECT_THAT(text, HasSubstr("__fish_use_subcommand -f -a " + command + " ")) << command;
  }
}

TEST_F(Completion, OfBashAndZshIsShellThatParses) {
  for (const char* shell : {"bash", "zsh"}) {
    write("completion.sh", run({"completion", shell}).out);
    // bash knows all of zsh that is used here.
    EXPECT_EQ(std::system(("cd " + folder_.path().string() + " && bash -n completion.sh").c_str()), 0)
        << shell;
  }
}

TEST_F(Completion, OfZshEscapesWhatDivides) {
  // Within '--option[about]:value:…' a bracket or colon of the text would end it.
  std::istringstream lines(run({"completion", "zsh"}).out);
  int options = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = line.find("--");
    if (!line.starts_with("        '") || start == std::string::npos) continue;
    ++options;
    const std::size_t open = line.find('[');
    ASSERT_NE(open, std::string::npos) << line;
    std::size_t close = open + 1;
    while (close < line.size() && line[close] != ']') close += line[close] == '\\' ? 2 : 1;
    ASSERT_LT(close, line.size()) << line;
    const std::string after = line.substr(close + 1);
    EXPECT_TRUE(after.starts_with(":") || after.starts_with("'")) << line;
    for (std::size_t i = open + 1; i < close; i += line[i] == '\\' ? 2 : 1) {
      EXPECT_TRUE(line[i] != ':' && line[i] != '[') << line;
    }
  }
  EXPECT_GT(options, 50);
}

// Those of a group, of which init takes exactly one, are options too.
TEST_F(Completion, EveryOptionOfTheHelpIsOffered) {
  const std::string bash = run({"completion", "bash"}).out;
  for (const std::string& command : commands()) {
    const std::size_t at = bash.find("    " + command + ") options='");
    ASSERT_NE(at, std::string::npos) << command;
    const std::string offered = bash.substr(at, bash.find('\n', at) - at) + " ";
    EXPECT_EQ(offered.find("--help"), offered.rfind("--help")) << command;
    std::istringstream help(run({"help", command}).out);
    for (std::string line; std::getline(help, line);) {
      const std::size_t first = line.find_first_not_of(' ');
      if (first == std::string::npos || first == 0 || first > 4 || !line.substr(first).starts_with("-"))
        continue;
      const std::size_t option = line.find("--");
      const std::string name = line.substr(option, line.find_first_of(" ,[", option) - option);
      EXPECT_TRUE(offered.find(name + " ") != std::string::npos ||
                  offered.find(name + "'") != std::string::npos)
          << command << ' ' << name;
    }
  }
}

}  // namespace
}  // namespace credence::internal
