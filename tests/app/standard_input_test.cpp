// What `credence check -` reads: text or binary frames, to the end or until it is interrupted.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Binary frames of one innovation and its S; the rows are run, step, ν, S.
std::string frames(const std::vector<std::vector<double>>& rows) {
  std::string bytes = "# credence frames 1\n# a comment\nrun,step,innovation.1,S.1.1\n";
  for (const std::vector<double>& row : rows) {
    std::string values(row.size() * sizeof(double), '\0');
    std::memcpy(values.data(), row.data(), values.size());
    bytes += values;
  }
  return bytes;
}

class StandardInput : public CommandTest {
 protected:
  /// `credence check -` with a file as its input, its temporary files in the test's own folder.
  pid_t begin_check(const std::string& input) const {
    fs::create_directories(folder_ / "tmp");
    return start_program(
        {"sh", "-c", "exec env TMPDIR=tmp " + credence_binary().string() + " check - --quiet < " + input});
  }
  Finished check(const std::string& input) const { return finish(begin_check(input)); }
};

TEST_F(StandardInput, FramesHoldTheNumbersOfTheirText) {
  std::string text = "run,step,innovation.1,S.1.1\n";
  std::vector<std::vector<double>> rows;
  for (int run = 0; run < 3; ++run) {
    for (int step = 1; step <= 20; ++step) {
      const double nu = 0.1 * ((7 * step + 3 * run) % 19 - 9);
      rows.push_back({static_cast<double>(run), static_cast<double>(step), nu, 0.3});
      text += std::to_string(run) + "," + std::to_string(step) + "," + Json(nu).dump() + ",0.3\n";
    }
  }
  write("text", text);
  write("frames", frames(rows));
  const Finished of_text = check("text"), of_frames = check("frames");
  EXPECT_EQ(of_text.code, 0) << of_text.err;
  EXPECT_EQ(of_frames.out, of_text.out);
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

TEST_F(StandardInput, AStepThatIsNoWholeNumberAndARunWithoutBoundsAreRefusedAsInText) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<std::vector<double>, const char*>> cases = {
      {{0, 1.7, 0.5, 1}, "step 1.7: accepted are"},
      {{0, 1e300, 0.5, 1}, "step 1e+300"},
      {{kInfinity, 1, 0.5, 1}, "inf"}};
  for (const auto& [row, said] : cases) {
    write("frames", frames({row, row}));
    const Finished f = check("frames");
    EXPECT_EQ(f.code, 2) << said << f.out;
    EXPECT_THAT(f.err, HasSubstr(said));
  }
}

TEST_F(StandardInput, FramesThatBreakOffAreRefused) {
  const std::string whole = frames({{0, 1, 0.5, 1}});
  write("row", whole.substr(0, whole.size() - 3));
  EXPECT_THAT(check("row").err, HasSubstr("row 1 breaks off after 29 of 32 bytes"));
  write("names", "# credence frames 1\nrun,step");
  EXPECT_THAT(check("names").err, HasSubstr("no line with names of columns"));
  EXPECT_EQ(check("names").code, 2);
}

TEST_F(StandardInput, IsNamedWhereItIsWrong) {
  write("text", "step,error.x,P.1.1\n1,a,1\n");
  EXPECT_THAT(check("text").err, ::testing::StartsWith("credence: /dev/stdin:2: column error.x: 'a'"));
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

TEST_F(StandardInput, IsRefusedWhereItCannotBeKept) {
  write("text", "");
  const Finished f = finish(start_program(
      {"sh", "-c", "exec env TMPDIR=absent " + credence_binary().string() + " check - < text"}));
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err,
            "credence: absent: standard input cannot be kept there (No such file or directory); TMPDIR names "
            "another folder\n");
}

TEST_F(StandardInput, LeavesNoFileBehindWhereNobodyReadsTheAnswer) {
  write("frames", frames({{0, 1, 0.5, 1}, {0, 2, 0.5, 1}}));
  fs::create_directories(folder_ / "tmp");
  finish(start_program({"sh", "-c",
                        "{ while [ ! -e closed ]; do sleep 0.01; done; cat frames; } | { env TMPDIR=tmp " +
                            credence_binary().string() +
                            " check - --quiet; echo $? > code; } | { exec <&-; touch closed; }"}));
  EXPECT_EQ(read("code"), std::to_string(128 + SIGPIPE) + "\n");
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

TEST_F(StandardInput, AnInterruptionWhileItWaitsLeavesNoFileBehind) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  const pid_t writer = start_program({"sh", "-c", "exec sleep 60 > pipe"});
  const pid_t child = begin_check("pipe");
  const auto waits = [&] { return fs::exists(folder_ / "tmp") && !fs::is_empty(folder_ / "tmp"); };
  wait_for(waits);
  ASSERT_TRUE(waits());
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  kill(writer, SIGKILL);
  finish(writer);
  EXPECT_EQ(f.code, 130) << f.err;
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

}  // namespace
}  // namespace credence::internal
