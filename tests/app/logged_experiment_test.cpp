// `credence run --log`: the logs, and that `credence check` says of them what the run said.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class LoggedExperiment : public CommandTest {};

TEST_F(LoggedExperiment, RefusesToMixLogsAndDiscardsThemWhenAsked) {
  write("a.toml", kLine);
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs", "--quiet"}).code, 0);
  const Finished again = run({"run", "a.toml", "--log", "logs", "--quiet", "--runs", "70"});
  EXPECT_EQ(again.code, 2);
  EXPECT_NE(again.err.find("holds logs of earlier runs"), std::string::npos) << again.err;
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs", "--quiet", "--runs", "70", "--fresh"}).code, 0);
  EXPECT_EQ(json({"check", "logs", "--format", "json", "--quiet"})["runs"], 70);
}

TEST_F(LoggedExperiment, TwoAtOnceDoNotShareAFolder) {
  write("a.toml", kLine);
  const pid_t first = start({"run", "a.toml", "--runs", "1000000", "--log", "logs", "--format", "json"});
  wait_for([&] { return fs::exists(folder_ / "logs" / "run-000000.csv"); });
  const Finished second = finish(start_program(
      {"sh", "-c", credence_binary().string() + " run a.toml --log logs --fresh > second 2>&1"}));
  EXPECT_EQ(second.code, 2);
  EXPECT_EQ(read("second"), "credence: logs: another process (pid " + std::to_string(first) +
                                ") is writing there; wait for it, or name another folder\n");
  kill(first, SIGINT);
  EXPECT_EQ(finish(first).code, 130);
  EXPECT_TRUE(fs::exists(folder_ / "logs" / "run-000000.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "logs" / "run.lock"));
}

TEST_F(LoggedExperiment, CtrlCLeavesWholeLogsOfTheRunsThatItReports) {
  write("a.toml", kLine);
  const pid_t child =
      start({"run", "a.toml", "--runs", "1000000", "--log", "logs", "--format", "json", "--quiet"});
  for (int i = 0; i < 20000 && !fs::exists(folder_ / "logs" / "run-000070.csv"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  kill(child, SIGINT);
  const Finished f = finish(child);
  ASSERT_EQ(f.code, 130) << f.err;
  const Json run = Json::parse(f.out);
  EXPECT_EQ(run["complete"], false);
  const Json check = json({"check", "logs", "--format", "json", "--quiet"});
  EXPECT_EQ(check["runs"], run["runs"]);
  EXPECT_EQ(check["nees"], run["nees"]);
}

// Within the first chunk, of which some logs are there.
TEST_F(LoggedExperiment, CtrlCBeforeAResultLeavesTheLogsAndSaysSo) {
  const pid_t child = start(
      {"run", scenario_file("planar_loop"), "--runs", "64", "--threads", "1", "--log", "logs", "--quiet"});
  wait_for([&] { return fs::exists(folder_ / "logs" / "run-000002.csv"); });
  kill(child, SIGINT);
  const Finished f = finish(child);
  ASSERT_EQ(f.code, 130) << f.err;
  EXPECT_NE(f.err.find("interrupted before the first runs were judged; those whose logs are in logs can be: "
                       "credence check logs; --fresh begins anew"),
            std::string::npos)
      << f.err;
  EXPECT_GE(json({"check", "logs", "--format", "json", "--quiet"})["runs"], 3);
}

// The states of these worlds are no vectors: what their logs hold differs by the error in the judged chart.
TEST_F(LoggedExperiment, WorldsOnGroupsRunSweepAndLog) {
  for (const char* name : {"localisation", "inertial"}) {
    const auto with = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.begin() + 1, {scenario_file(name), "--runs", "64", "--set", "study.steps=20",
                                               "--set", "world.aiding_interval=5"});
      return arguments;
    };
    const std::string logs = std::string("logs of ") + name;
    ASSERT_EQ(run(with({"run", "--log", logs, "--out", name})).code, 0) << name;
    const Json judged = json({"check", logs, "--format", "json"}),
               own = json(with({"run", "--format", "json"}));
    EXPECT_NEAR(judged["nees"]["mean"].get<double>(), own["nees"]["mean"].get<double>(), 1e-6) << name;
    EXPECT_NEAR(judged["nis"]["mean"].get<double>(), own["nis"]["mean"].get<double>(), 1e-9) << name;
    EXPECT_EQ(own["rmse"]["position_m"].size(), 20U);
    EXPECT_THAT(read(std::filesystem::path(name) / "index.html"), HasSubstr("error in the "));
    const Finished sweep = run(with({"sweep", "--set", "sweep.filter.chart=componentwise,right,left", "--out",
                                     std::string("swept ") + name}));
    EXPECT_EQ(sweep.code, 0) << sweep.err;
  }
}

// Step 10 of 0.5 s is at 5 s, whether the world says it or a log of it.
TEST_F(LoggedExperiment, ARunAndItsLogsTellTimesWhereTheWorldHasThem) {
  const std::vector<std::string> study = {
      scenario_file("tracking"),  "--runs", "64", "--steps", "40", "--set", "world.dt=0.5", "--set",
      "filter.process_scale=0.02"};
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin() + 1, study.begin(), study.end());
    return arguments;
  };
  const Json own = json(with({"run", "--format", "json"}))["nees"]["optimistic_steps"];
  ASSERT_TRUE(own.is_object());
  EXPECT_EQ(own["first_time_s"], 0.5 * own["first"].get<double>());
  EXPECT_EQ(own["last_time_s"], 0.5 * own["last"].get<double>());
  for (const char* format : {"csv", "npz"}) {
    ASSERT_EQ(run(with({"run", "--log", format, "--log-format", format, "--quiet"})).code, 0);
    EXPECT_EQ(json({"check", format, "--format", "json"})["nees"]["optimistic_steps"], own) << format;
  }
  ASSERT_EQ(
      run({"run", scenario_file("figure1_two_landmarks"), "--runs", "1", "--log", "line", "--quiet"}).code,
      0);
  EXPECT_THAT(read("line/run-000000.csv"), testing::StartsWith("step,estimate."));
}

// P of the invariant filters is that of an error in SE(2), and so must be what a log writes beside it.
TEST_F(LoggedExperiment, LogsOfInvariantEstimatorsHoldTheErrorOfTheirP) {
  for (const char* estimator : {"ekf", "invariant", "invariant-left", "ukf-manifold"}) {
    const std::string logs = std::string("logs of ") + estimator;
    const std::string chosen = std::string("filter.estimator=") + estimator;
    const auto of_run = [&](std::vector<std::string> more) {
      std::vector<std::string> all{
          "run",   scenario_file("ukfm_slam2d"), "--runs", "40",  "--set", "study.steps=60",
          "--set", "initial.position_std=0.01",  "--set",  chosen};
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    ASSERT_EQ(run(of_run({"--log", logs})).code, 0) << estimator;
    const Json judged = json({"check", logs, "--format", "json"}), own = json(of_run({"--format", "json"}));
    const double nees = own["nees"]["mean"].get<double>();
    EXPECT_NEAR(judged["nees"]["mean"].get<double>(), nees, 1e-6 * nees) << estimator;
    EXPECT_EQ(judged["nees"]["dof"], own["nees"]["dof"]) << estimator;
    EXPECT_EQ(judged["verdict"], own["verdict"]) << estimator;
  }
}

TEST_F(LoggedExperiment, OnlyLogsOfRunsAreDiscarded) {
  write("a.toml", kLine);
  fs::create_directories(folder_ / "logs");
  const std::vector<std::string> others{"notes.csv", "run-.csv",   "run-1a.csv",
                                        "run-1.txt", "run--1.csv", "run-1.csv.bak"};
  for (const std::string& name : others) write("logs/" + name, "kept");
  for (const char* name : {"run-000007.npz", "run-1.csv", "run-000200.mcap"})
    write(std::string("logs/") + name, "old");
  const Finished mixed = run({"run", "a.toml", "--runs", "2", "--log", "logs", "--quiet"});
  EXPECT_EQ(mixed.code, 2);
  EXPECT_EQ(
      mixed.err,
      "credence: logs: holds logs of earlier runs; name another folder, or discard them with --fresh\n");
  ASSERT_EQ(run({"run", "a.toml", "--runs", "2", "--log", "logs", "--quiet", "--fresh"}).code, 0);
  for (const std::string& name : others) EXPECT_EQ(read("logs/" + name), "kept") << name;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "logs"), {}), std::ssize(others) + 2);
  EXPECT_TRUE(fs::exists(folder_ / "logs/run-000000.csv") && fs::exists(folder_ / "logs/run-000001.csv"));
}

TEST_F(LoggedExperiment, AFormatThatTheWorldHasNotMakesNoFolder) {
  write("a.toml", kLine);
  const Finished f = run({"run", "a.toml", "--log", "logs", "--log-format", "mcap"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(
      f.err,
      "credence: --log-format mcap: this world has no pose in the plane; csv and npz take every world\n");
  EXPECT_FALSE(fs::exists(folder_ / "logs"));
}

// One step is good; then P is 0, and S of the second.
TEST_F(LoggedExperiment, ARunThatFailedEndsWithItsLastGoodStepAndSaysWhy) {
  write("f.toml",
        "[world]\nmodel = \"linear\"\nF = [[1]]\nH = [[1]]\nQ = [[0]]\nR = [[0]]\nP0 = [[1]]\n"
        "[study]\nruns = 2\nsteps = 5\n");
  EXPECT_EQ(run({"run", "f.toml", "--log", "logs", "--quiet"}).code, 3);
  const std::string log = read("logs/run-000001.csv");
  EXPECT_THAT(log, HasSubstr("not_positive_definite at step 2"));
  EXPECT_EQ(json({"check", "logs", "--format", "json", "--quiet"}, 3)["rows"], 2)
      << "one good step of each run, of which P is 0";
}

// The rows of a run before it fails are no average over a run.
TEST_F(LoggedExperiment, RunsThatFailAreNoMorePartOfTheFactorOnPThanWithoutLogs) {
  const std::vector<std::string> study = {"run",       scenario_file("huang_ring"),
                                          "--runs",    "20",
                                          "--steps",   "100",
                                          "--set",     "noise.turn_rate_std=0.6",
                                          "--set",     "noise.relative_position_std=2",
                                          "--threads", "1",
                                          "--format",  "json",
                                          "--quiet"};
  std::vector<std::string> with_logs = study;
  with_logs.insert(with_logs.end(), {"--log", "logs"});
  const Finished plain = run(study), logged = run(with_logs);
  ASSERT_EQ(plain.code, 3) << "some runs fail";
  ASSERT_EQ(logged.code, 3);
  const Json of_plain = Json::parse(plain.out), of_logged = Json::parse(logged.out),
             of_check = Json::parse(run({"check", "logs", "--pool", "--format", "json", "--quiet"}).out);
  EXPECT_EQ(of_logged["nees"]["factor"], of_plain["nees"]["factor"]);
  EXPECT_EQ(of_check["nees"]["factor"], of_plain["nees"]["factor"]);
}

TEST_F(LoggedExperiment, SeveralScenariosHaveAFolderEach) {
  write("a.toml", kLine);
  write("b.toml", kLine);
  ASSERT_EQ(run({"run", "a.toml", "b.toml", "--runs", "2", "--log", "logs", "--quiet"}).code, 0);
  for (const char* name : {"logs/a/run-000001.csv", "logs/b/run-000001.csv"})
    EXPECT_NE(read(name), "") << name;
  EXPECT_EQ(read("logs/a/run-000001.csv"), read("logs/b/run-000001.csv")) << "the same seed";
}

}  // namespace
}  // namespace credence::internal
