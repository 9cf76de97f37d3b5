// What `credence run` and `credence sweep` share: stores, their scenario, exit codes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"
#include "tests/app/unread_output.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class StudyRunner : public CommandTest {};

TEST_F(StudyRunner, MoreStepsThanAStoreTakesAreRefusedBeforeTheyAreMade) {
  write("a.toml", kMonobot);
  for (const char* command : {"run", "sweep"}) {
    const Finished f = run({command, "a.toml", "--runs", "1", "--steps", "4000000", "--out", "out"});
    EXPECT_EQ(f.code, 2) << command;
    EXPECT_THAT(f.err, testing::EndsWith("credence: a.toml: study.steps = 4000000: at most 3289462 can be "
                                         "stored\n"))
        << command;
    EXPECT_FALSE(fs::exists(folder_ / "out")) << command;
  }
}

TEST_F(StudyRunner, AChangedScenarioIsRefusedWithTheDifference) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  EXPECT_EQ(run({"run", "a.toml", "--out", "out", "--runs", "500"}).code, 0) << "more runs extend a study";
  const std::string before = read("out/a.csv");
  const Finished f = run({"run", "a.toml", "--out", "out", "--set", "noise.process_variance=0.2"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("process_variance"), std::string::npos) << f.err;
  EXPECT_EQ(read("out/a.csv"), before);
  EXPECT_EQ(run({"run", "a.toml", "--out", "out", "--fresh", "--set", "noise.process_variance=0.2"}).code, 0);
}

TEST_F(StudyRunner, AStudyThatGrowsIsTheOneThatWasLargeFromTheStart) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out", "--quiet"}).code, 0);
  const Finished grown = run({"run", "a.toml", "--out", "out", "--runs", "500", "--format", "json"});
  EXPECT_EQ(grown.out, run({"run", "a.toml", "--runs", "500", "--format", "json"}).out);
  EXPECT_EQ(Json::parse(grown.out)["runs"], 500);
}

TEST_F(StudyRunner, FailedRunsAreToldBeforeAnInconsistentVerdict) {
  // No noise and no doubt about the start: S is 0.
  write("fails.toml",
        "[world]\nmodel = \"monobot\"\n[noise]\nmeasurement_variance = 0\nprocess_variance = 0\n"
        "initial_variance = 0\n[study]\nruns = 3\nsteps = 2\n");
  write("wrong.toml", kMonobot + "[filter]\nmeasurement_scale = 0.5\n");
  const std::vector<std::string> all{"run", "fails.toml", "wrong.toml", "--fail-on-inconsistent"};
  EXPECT_EQ(run(all).code, 3);
  EXPECT_EQ(run({"run", "wrong.toml", "--fail-on-inconsistent"}).code, 1);
  EXPECT_EQ(run({"sweep", "wrong.toml", "--out", "out", "--fail-on-inconsistent"}).code, 1);
  EXPECT_EQ(run({"sweep", "wrong.toml", "--out", "out"}).code, 0);
}

TEST_F(StudyRunner, AShardHasNoStopRule) {
  write("s.toml", kMonobotSweep + "[study.stop]\nverdict = \"either\"\n");
  const Finished f = run({"sweep", "s.toml", "--shard", "1/2", "--out", "part"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err, "credence: --shard: not with study.stop, which must see the runs in their order\n");
  EXPECT_FALSE(fs::exists(folder_ / "part"));
}

// After the last commit, which sees by itself whether its file is there.
TEST_F(StudyRunner, AStoreThatGoesAwayWhileTheReportIsWrittenIsAnError) {
  write("a.toml", kMonobot);
  for (const char* command : {"run", "sweep"}) {
    fs::remove(folder_ / "stdout");
    const UnreadOutput output(folder_);
    const pid_t child =
        start({command, "a.toml", "--runs", "2", "--steps", "1000", "--out", "out", "--format", "json"});
    wait_for([&] { return output.has_begun(); });
    fs::rename(folder_ / "out", folder_ / (std::string("moved by ") + command));
    EXPECT_TRUE(Json::accept(output.read_all()));
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 2) << command;
    EXPECT_THAT(read("stderr"),
                ::testing::HasSubstr("credence: out: the stored results were moved or removed while the "
                                     "report was written\n"))
        << command;
    fs::remove_all(folder_ / "out");
  }
}

}  // namespace
}  // namespace credence::internal
