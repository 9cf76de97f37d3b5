// Ctrl-C, SIGTERM and SIGHUP while a command has something to save.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <string>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"
#include "tests/app/unread_output.h"

namespace credence::internal {
namespace {

class Interrupt : public CommandTest {};

// One chunk of these runs takes the better part of an hour.
TEST_F(Interrupt, AnInterruptionIsHeardWithinAChunk) {
  write("p.toml", kLongChunk);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t child = start({"run", "p.toml", "--out", "out"});
    wait_until_caught(child);
    kill(child, signal);
    const Finished f = finish(child);
    EXPECT_EQ(f.code, 130) << signal;
    EXPECT_NE(f.err.find("once more ends at once"), std::string::npos) << f.err;
    EXPECT_NE(f.err.find("Interrupted; what is done is stored. This goes on with it:"), std::string::npos)
        << f.err;
  }
}

TEST_F(Interrupt, AnInterruptionIsNotCaughtWhereItWasIgnored) {
  write("a.toml", kMonobot);
  signal(SIGINT, SIG_IGN);  // as a script does for what it starts in the background
  const pid_t child = start({"run", "a.toml", "--runs", "200000", "--out", "out", "--threads", "1"});
  signal(SIGINT, SIG_DFL);
  wait_for_chunks("out");
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 0);
}

// Its result is being written, and nobody reads it.
TEST_F(Interrupt, ASecondOneEndsAtOnce) {
  write("a.toml", kMonobot);
  const UnreadOutput output(folder_);
  const pid_t child =
      start({"run", "a.toml", "--runs", "2", "--steps", "1000", "--format", "json", "--quiet"});
  wait_for([&] { return output.has_begun(); });
  kill(child, SIGINT);
  wait_for([&] { return !read("stderr").empty(); });
  EXPECT_EQ(read("stderr"), "\ncredence: ending with what is done; once more ends at once\n");
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, WNOHANG), 0) << "the first one lets it write";
  kill(child, SIGINT);
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
}

// Each of the three signals ends it when it comes again, and only then.
TEST_F(Interrupt, AnInterruptionWhileTheResultIsWrittenLosesNothingOfIt) {
  write("a.toml", kMonobot);
  const UnreadOutput output(folder_);
  const pid_t child =
      start({"run", "a.toml", "--runs", "2", "--steps", "1000", "--format", "json", "--quiet"});
  wait_for([&] { return output.has_begun(); });
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) kill(child, signal);
  wait_for([&] { return !read("stderr").empty(); });
  EXPECT_TRUE(Json::accept(output.read_all()));
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "all of it was done";
}

}  // namespace
}  // namespace credence::internal
