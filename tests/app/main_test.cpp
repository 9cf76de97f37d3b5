// The program as a whole: its output, its codes, what it says at its end.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class Main : public CommandTest {};

TEST_F(Main, AFullDiskBehindTheOutputIsAnError) {
  write("a.toml", kMonobot);
  fs::create_symlink("/dev/full", folder_ / "stdout");
  for (const char* format : {"text", "json"}) {
    int status = 0;
    waitpid(start({"run", "a.toml", "--format", format}), &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 2) << format;
    EXPECT_NE(read("stderr").find("credence: "), std::string::npos) << format;
  }
}

TEST_F(Main, AfterAnInterruptionTheCommandThatContinuesIsToldAndDoesSo) {
  write("a b.toml", kMonobot);
  const pid_t child = start({"run", "a b.toml", "--fresh", "--runs", "100000000", "--out", "out"});
  wait_for_chunks("out");
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  const std::string told = credence_binary().string() + " run 'a b.toml' --runs 100000000 --out out\n";
  EXPECT_TRUE(f.err.ends_with(told)) << f.err << "\nmust end with " << told;
}

// A descriptor that is free would be that of the next file, and what is said would be written into the store.
TEST_F(Main, WhatIsSaidToAClosedStreamGoesIntoNoFile) {
  write("a.toml", kMonobot);
  const auto with = [&](const std::string& closed) {
    return finish(start_program(
        {"sh", "-c", "exec " + credence_binary().string() + " run a.toml --out out " + closed}));
  };
  const Finished mute = with("2>&-");
  EXPECT_EQ(mute.code, 0);
  EXPECT_EQ(mute.out, run({"run", "a.toml"}).out);
  const Finished closed = with(">&-");
  EXPECT_EQ(closed.code, 2);
  EXPECT_EQ(closed.err, "Report: out/index.html\ncredence: the output could not be written\n");
  EXPECT_EQ(with(">&- 2>&- <&-").code, 2);
  EXPECT_EQ(json({"show", "out", "--format", "json"})["runs"], 300) << "the store is whole";
}

// The file that says who writes is open all the time.
TEST_F(Main, WhatIsSaidOfAnInterruptionGoesIntoNoFileOfTheStore) {
  write("a.toml", kMonobot);
  const pid_t child =
      start_program({"sh", "-c",
                     "exec " + credence_binary().string() +
                         " run a.toml --runs 100000000 --out out --threads 1 --format json 2>&-"});
  wait_for_chunks("out");
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 130);
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(folder_ / "out")) {
    if (file.is_regular_file())
      EXPECT_EQ(read(file.path()).find("once more ends at once"), std::string::npos) << file;
  }
}

TEST_F(Main, ALimitOfTheSizeOfFilesIsAnErrorAndNoSignal) {
  write("a.toml", kMonobot);
  const Finished f = finish(start_program(
      {"sh", "-c", "ulimit -f 8; exec " + credence_binary().string() + " run a.toml --out out"}));
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("credence: out/results.sqlite: "), std::string::npos) << f.err;
}

TEST_F(Main, WithoutACommandItTellsWhatThereIs) {
  const Finished none = run({});
  EXPECT_EQ(none.code, 2) << "in a script it is a mistake";
  EXPECT_EQ(none.out, run({"--help"}).out);
  EXPECT_EQ(none.err, "");
  EXPECT_EQ(run({"--help"}).code, 0);
  EXPECT_EQ(run({"version"}).out, run({"--version"}).out);
  const Finished empty = run({""});
  EXPECT_EQ(empty.code, 2);
  EXPECT_EQ(empty.out, "");
}

TEST_F(Main, WhatTheSystemRefusesIsToldByItsName) {
  std::filesystem::create_symlink("loop", folder_ / "loop");
  EXPECT_EQ(refusal({"check", "loop"}), "credence: loop: Too many levels of symbolic links\n");
}

TEST_F(Main, ACommandThatEndsWellTellsNoWayOn) {
  write("a.toml", kMonobot);
  EXPECT_EQ(run({"run", "a.toml", "--out", "out", "--quiet"}).err, "");
  // Nothing was stored: the same command would begin anew.
  const pid_t child = start({"run", "a.toml", "--runs", "100000000", "--quiet"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.err.find("This goes on with it"), std::string::npos) << f.err;
}

}  // namespace
}  // namespace credence::internal
