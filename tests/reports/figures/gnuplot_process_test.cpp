#include "reports/figures/gnuplot_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/temporary_folder.h"

namespace credence {
namespace {

using namespace std::chrono_literals;

TEST(Process, FeedsAndCollects) {
  const ProcessResult result = run_process({"cat"}, "some text", 5s);
  EXPECT_EQ(result.start_error, 0);
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.output, "some text");
}

TEST(Process, LargeStreamsDoNotBlock) {
  const std::string text(3'000'000, 'x');
  EXPECT_EQ(run_process({"cat"}, text, 20s).output, text);
}

TEST(Process, KeepsErrorsAndStatus) {
  const ProcessResult result = run_process({"sh", "-c", "echo wrong >&2; exit 7"}, "", 5s);
  EXPECT_EQ(result.exit_status, 7);
  EXPECT_EQ(result.errors, "wrong\n");
}

TEST(Process, AMissingProgramIsNamedByErrno) {
  EXPECT_EQ(run_process({"/nonexistent/program"}, "", 5s).start_error, ENOENT);
  EXPECT_EQ(run_process({"/dev/null"}, "", 5s).start_error, EACCES);
}

// A program that does not read must not end its caller by SIGPIPE.
TEST(Process, AProgramThatEndsEarlyIsNoTrouble) {
  const ProcessResult result = run_process({"true"}, std::string(3'000'000, 'x'), 5s);
  EXPECT_EQ(result.exit_status, 0);
}

TEST(Process, ReportsSignals) {
  EXPECT_EQ(run_process({"sh", "-c", "kill -SEGV $$"}, "", 5s).signal, SIGSEGV);
}

TEST(Process, KillsWhatTakesTooLongWithItsChildren) {
  const TemporaryFolder folder;
  const std::string late = (folder / "late").string();
  const auto start = std::chrono::steady_clock::now();
  const ProcessResult result =
      run_process({"sh", "-c", "echo early; (sleep 0.4; touch '" + late + "') & sleep 30"}, "", 100ms);
  EXPECT_TRUE(result.timed_out);
  EXPECT_EQ(result.output, "early\n");
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
  std::this_thread::sleep_for(600ms);
  EXPECT_FALSE(std::filesystem::exists(late)) << "a child of the program lived on";
}

TEST(Process, ArgumentsAreNotInterpreted) {
  EXPECT_EQ(run_process({"printf", "%s", "$HOME `id` ; '"}, "", 5s).output, "$HOME `id` ; '");
}

}  // namespace
}  // namespace credence
