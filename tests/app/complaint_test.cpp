// What is wrong with a command line, in one sentence.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class Complaint : public CommandTest {};

TEST_F(Complaint, IsOneSentenceWithWhereTheRightWordsAreListed) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"run"}, "run: scenario is required (credence help run)"},
      {{"run", "planar_loop", "--only-run", "1e4"},
       "run: --only-run = 1e4 is no whole number (credence help run)"},
      {{"run", "planar_loop", "--runs", "1e4"},
       "run: --runs 1e4: accepted are whole numbers from 1 to 1000000000 (credence help run)"},
      {{"plan", "planar_loop", "--power", "high"}, "plan: --power = high is no number (credence help plan)"},
      {{"run", "planar_loop", "--format", "yaml"},
       "run: --format: yaml not in {text,json,latex} (credence help run)"},
      {{"run", "planar_loop", "--threads", "5000"},
       "run: --threads 5000: accepted are whole numbers from 0 to 4096 (credence help run)"},
      {{"check", "a.csv", "--max-time-difference", "-1"},
       "check: --max-time-difference -1: accepted are numbers above 0 (credence help check)"},
      {{"check", "a.csv", "--max-time-difference", "abc"},
       "check: --max-time-difference abc: accepted are numbers above 0 (credence help check)"},
      {{"check", "a.csv", "--confidence", "95"},
       "check: --confidence 95: accepted are numbers from 0.5 to 0.999999 (credence help check)"},
      {{"selftest", "--seed", "-1"},
       "selftest: --seed -1: accepted are whole numbers from 0 on (credence help selftest)"},
      {{"run", "planar_loop", "--only-run", "3", "--out", "out"},
       "run: --out excludes --only-run (credence help run)"},
      {{"run", "planar_loop", "--runs"}, "run: --runs: the value is missing (credence help run)"},
      {{"run", "planar_loop", "--runs", "3", "--runs", "4"},
       "run: --runs: is given more than once (credence help run)"},
      {{"run", "planar_loop", "--runs", "010"},
       "run: --runs: 010 begins with 0; numbers are written in decimal (credence help run)"},
      {{"run", "planar_loop", "--threads", "0x2"},
       "run: --threads: 0x2 begins with 0; numbers are written in decimal (credence help run)"},
      {{"timing", "--landmarks", "10,020"},
       "timing: --landmarks: 020 begins with 0; numbers are written in decimal (credence help timing)"},
      {{"run", "planar_loop", "--format", "a\nb"},
       "run: --format: a b not in {text,json,latex} (credence help run)"},
      {{"plan", "planar_loop", "extra"}, "plan: extra is not expected (credence help plan)"},
      // The option is what is wrong, not the words that it would have taken.
      {{"plan", "planar_loop", "extra", "--bogus", "3"},
       "plan: --bogus is not expected (credence help plan)"}};
  for (const auto& [arguments, message] : cases) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2) << message;
    EXPECT_EQ(f.out, "") << message;
    EXPECT_EQ(f.err, "credence: " + message + "\n");
  }
}

TEST_F(Complaint, OptionsBelongBehindTheirCommand) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--threads", "2", "run", "planar_loop"},
       "run: --threads stands before the command and belongs behind it (credence help run)"},
      {{"--bogus"}, "--bogus is not expected (credence help)"},
      {{"--quiet", "2"}, "--quiet is not expected (credence help)"}};
  for (const auto& [arguments, message] : cases) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2) << message;
    EXPECT_EQ(f.err, "credence: " + message + "\n");
  }
}

}  // namespace
}  // namespace credence::internal
