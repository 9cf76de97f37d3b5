// What the program says on stderr: other people's names, and nobody who listens.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class Say : public CommandTest {};

TEST_F(Say, NamesReachTheTerminalWithoutTheirEscapes) {
  const std::string red = "\x1b[31m", reversed = "\xE2\x80\xAE";
  write(red + reversed + ".toml", kMonobot);
  const Finished stopped = run({"run", red + reversed + ".toml", "--set", "study.stop.verdict=either"});
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_EQ(stopped.out.find('\x1b'), std::string::npos) << stopped.out;
  const Finished missing = run({"run", red + reversed});
  EXPECT_EQ(missing.code, 2);
  const Finished unknown = run({"run", "a.toml", "--" + red + reversed});
  EXPECT_EQ(unknown.code, 2);
  for (const std::string& text : {missing.err, unknown.err}) {
    EXPECT_NE(text.find("[31m"), std::string::npos) << text;
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
    EXPECT_EQ(text.find(reversed), std::string::npos) << text;
  }
}

// A disk that is full under the log of a study, or nobody who reads it, costs no results.
TEST_F(Say, WhatCannotBeSaidEndsNothing) {
  write("a.toml", kMonobot);
  fs::create_symlink("/dev/full", folder_ / "stderr");
  const auto code = [&](const std::vector<std::string>& arguments) {
    int status = 0;
    waitpid(start(arguments), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  };
  EXPECT_EQ(code({"run", "missing.toml"}), 2);
  EXPECT_EQ(code({"run", "a.toml", "--bogus"}), 2);
  EXPECT_EQ(code({"run", "a.toml", "--out", "out"}), 0);
}

// Results wait in a buffer where nobody sits at a terminal.
TEST_F(Say, WhatIsSaidStandsBehindTheResultsWhereBothGoToOnePlace) {
  write("a.toml", kMonobot);
  finish(start_program(
      {"sh", "-c", "exec " + credence_binary().string() + " run a.toml --out out > both 2>&1"}));
  const std::string report = "Report: out/index.html\n", both = read("both");
  EXPECT_TRUE(both.ends_with(report)) << both;
  EXPECT_EQ(both.substr(0, both.size() - report.size()), run({"run", "a.toml"}).out);
}

TEST_F(Say, AMessageOfSeveralLinesKeepsThemAndALineEndInANameIsNone) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out\nput", "--quiet"}).code, 0);
  const Finished f = run({"run", "a.toml", "--out", "out\nput", "--set", "noise.process_variance=0.2"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("(- stored, + asked):\n- noise.process_variance = 0.1"), std::string::npos) << f.err;
}

}  // namespace
}  // namespace credence::internal
