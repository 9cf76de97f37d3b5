// How far a long study is: on a terminal, in a log, and where nobody wants to know.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <regex>
#include <string>
#include <utility>

#include "tests/app/small_studies.h"
#include "tests/app/terminal.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Progress : public TerminalTest {};

// All at once, since nothing is shown in the first two seconds.
TEST_F(Progress, IsABarOnATerminalALineInALogAndNothingForTheQuiet) {
  write("a.toml", kMonobot);
  for (const char* folder : {"quiet", "log"}) std::filesystem::create_directory(folder_ / folder);
  Terminal wide(120), narrow(12);
  const auto in_background = [&](const std::string& redirection) {
    return start_program(
        {"sh", "-c",
         "exec " + credence_binary().string() + " run a.toml --runs 100000000 --threads 1 " + redirection});
  };
  const pid_t quiet = in_background("--quiet > quiet/out 2> quiet/err"),
              log = in_background("> log/out 2> log/err"),
              on_wide = in_background("> wide.out 2> " + wide.name()),
              on_narrow = in_background("> narrow.out 2> " + narrow.name());
  wait_for([&] {
    return wide.text().find(" left\x1b[K") != std::string::npos && !read("log/err").empty() &&
           narrow.text().find("%") != std::string::npos;
  });
  for (const pid_t child : {quiet, log, on_wide, on_narrow}) kill(child, SIGINT);
  wide.text_until_end_of(on_wide);
  narrow.text_until_end_of(on_narrow);
  for (const pid_t child : {quiet, log, on_wide, on_narrow}) EXPECT_EQ(finish(child).code, 130);

  EXPECT_THAT(wide.text(),
              ::testing::ContainsRegex("\ra [█·]+ [0-9]+ of 100000000 runs, [0-9]+ runs/s, [0-9:]+ "
                                       "(s|min|h) left\x1b\\[K"));
  const std::size_t last = wide.text().rfind(" left");
  EXPECT_NE(wide.text().find("\r\x1b[K", last), std::string::npos)
      << "the bar is wiped away: " << wide.text();
  EXPECT_THAT(narrow.text(), ::testing::ContainsRegex("\r[0-9]+ %\x1b\\[K"));
  EXPECT_THAT(narrow.text(), Not(HasSubstr("of 100000000")));
  EXPECT_THAT(read("log/err"), ::testing::MatchesRegex(
                                   "a: [0-9]+ %, [0-9]+ of 100000000 runs, [0-9]+ runs/s, [0-9:]+ (s|min|h) "
                                   "left\n(.|\n)*"));
  EXPECT_EQ(read("log/err").find('\x1b'), std::string::npos);
  EXPECT_EQ(read("log/err").find('\r'), std::string::npos);
  EXPECT_EQ(read("quiet/err"), "\ncredence: ending with what is done; once more ends at once\n");
}

TEST_F(Progress, CountsTheRunsInHand) {
  // All 40 are of one chunk, of which none is done before all are; of estimators all 6 are of one task.
  for (const auto& [command, runs] :
       {std::pair{" run planar_loop --runs 40 --steps 40000", "40"},
        {" estimators ukfm_slam2d --estimators ekf,fej --runs 6 --steps 400000", "6"}}) {
    std::filesystem::create_directory(folder_ / "log");
    const pid_t child = start_program(
        {"sh", "-c", "exec " + credence_binary().string() + command + " --threads 1 > log/out 2> log/err"});
    const std::regex some(std::string(" %, [1-9][0-9]* of ") + runs + " runs, ");
    wait_for([&] { return std::regex_search(read("log/err"), some); });
    kill(child, SIGINT);
    EXPECT_EQ(finish(child).code, 130) << command;
    EXPECT_TRUE(std::regex_search(read("log/err"), some)) << read("log/err");
    EXPECT_THAT(read("log/err"), Not(HasSubstr(" 0 runs/s")))
        << "nothing is told of a rate before it is known";
    std::filesystem::remove_all(folder_ / "log");
  }
}

TEST_F(Progress, OfAPlanIsThatOfItsPilot) {
  write("p.toml", kLongChunk);
  const pid_t child =
      start_program({"sh", "-c", "exec " + credence_binary().string() + " plan p.toml > out 2> err"});
  const std::regex some("plan: [1-9][0-9]* steps of a pilot in ");
  wait_for([&] { return std::regex_search(read("err"), some); });
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 130);
}

}  // namespace
}  // namespace credence::internal
