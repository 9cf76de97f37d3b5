// `credence run` where something goes wrong: another process, a store that is gone, an interruption.

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

const std::string kOneLandmark =
    "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 300\nsteps = 30\n";
const std::string kPlanar = "[world]\nmodel = \"planar\"\nlandmarks = 10\n[study]\nruns = 640\nsteps = 400\n";

const std::string kLongChunk =
    "[world]\nmodel = \"planar\"\nlandmarks = 100\n[study]\nruns = 64\nsteps = 20000\n";

class RunCommand : public CommandTest {
 protected:
  /// Until chunks have been written to the store of this folder.
  void wait_for_chunks(const fs::path& folder) const {
    wait_for([&] {
      std::error_code none;
      const std::uintmax_t size = fs::file_size(folder_ / folder / "results.sqlite-wal", none);
      return !none && size > 60000;
    });
  }
};

TEST_F(RunCommand, FreshLeavesTheStoreOfAProcessThatWrites) {
  write("a.toml", kOneLandmark);
  const pid_t child =
      start({"run", "a.toml", "--runs", "100000000", "--out", "out", "--threads", "1", "--format", "json"});
  wait_for_chunks("out");
  const Finished second = run({"run", "a.toml", "--out", "out", "--fresh"});
  EXPECT_EQ(second.code, 2);
  EXPECT_NE(second.err.find("is writing there"), std::string::npos) << second.err;
  EXPECT_TRUE(fs::exists(folder_ / "out/results.sqlite"));
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 130);
  const Finished third = run({"run", "a.toml", "--out", "out", "--fresh"});
  EXPECT_EQ(third.code, 0) << third.err;
}

TEST_F(RunCommand, AStoreThatGoesAwayIsAnError) {
  write("a.toml", kOneLandmark);
  const pid_t child = start({"run", "a.toml", "--runs", "100000000", "--out", "out", "--threads", "1"});
  wait_for_chunks("out");
  fs::rename(folder_ / "out", folder_ / "moved");
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("out/results.sqlite: was moved or removed"), std::string::npos) << f.err;
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "no page without results";
}

TEST_F(RunCommand, MoreStepsThanAStoreTakesAreRefusedBeforeTheyAreMade) {
  write("a.toml", kOneLandmark);
  const Finished f = run({"run", "a.toml", "--runs", "1", "--steps", "4000000", "--out", "out"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err, "credence: a.toml: study.steps = 4000000: at most 3906236 can be stored\n");
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

// A disk that is full under the log of a study, or nobody who reads it, costs no results.
TEST_F(RunCommand, WhatCannotBeSaidEndsNothing) {
  write("a.toml", kOneLandmark);
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

TEST_F(RunCommand, AnInterruptionInTheFurtherTestsIsTold) {
  write("p.toml", kPlanar);
  ASSERT_EQ(run({"sweep", "p.toml", "--out", "out"}).code, 0);  // stores all runs, makes no further tests
  const pid_t child = start({"run", "p.toml", "--out", "out", "--format", "json", "--threads", "1"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["runs"], 640) << "it must be the further tests that were interrupted";
  EXPECT_EQ(j["complete"], false);
  EXPECT_FALSE(j.contains("battery"));
}

// One chunk of these runs takes the better part of an hour.
TEST_F(RunCommand, AnInterruptionIsHeardWithinAChunk) {
  write("p.toml", kLongChunk);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t child = start({"run", "p.toml", "--out", "out"});
    wait_until_caught(child);
    kill(child, signal);
    const Finished f = finish(child);
    EXPECT_EQ(f.code, 130) << signal;
    EXPECT_NE(f.err.find("once more ends at once"), std::string::npos) << f.err;
    EXPECT_NE(f.err.find("interrupted before the first runs"), std::string::npos) << f.err;
  }
}

TEST_F(RunCommand, AnInterruptionIsNotCaughtWhereItWasIgnored) {
  write("a.toml", kOneLandmark);
  signal(SIGINT, SIG_IGN);  // as a script does for what it starts in the background
  const pid_t child = start({"run", "a.toml", "--runs", "200000", "--out", "out", "--threads", "1"});
  signal(SIGINT, SIG_DFL);
  wait_for_chunks("out");
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 0);
}

TEST_F(RunCommand, APlanHasNothingToSaveAndEndsAtOnce) {
  write("p.toml", kLongChunk);
  const pid_t child = start({"plan", "p.toml", "--quiet"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGINT);
  EXPECT_EQ(finish(child).code, 128 + SIGINT);
}

TEST_F(RunCommand, WhatNeedsMoreMemoryThanThereIsIsRefusedByKey) {
  write("a.toml", kOneLandmark);
  write("p.toml", kPlanar);
  for (const char* file : {"a.toml", "p.toml"}) {
    const Finished f = run({"run", file, "--set", "world.landmarks=1000000", "--set", "study.steps=5"});
    EXPECT_EQ(f.code, 2);
    EXPECT_NE(f.err.find(std::string(file) + ": world.landmarks = 1000000"), std::string::npos) << f.err;
    EXPECT_NE(f.err.find("GB of memory"), std::string::npos) << f.err;
  }
  const Finished f = run({"sweep", "a.toml", "--runs", "1000000000", "--set",
                          "sweep.noise.process_variance=lin(1, 2, 100000)", "--set", "study.steps=1"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("study.runs"), std::string::npos) << f.err;
}

TEST_F(RunCommand, AMeasurementWithoutNoiseIsReported) {
  write("a.toml", kOneLandmark + "[noise]\nmeasurement_variance = 0\n");
  const Finished f = run({"run", "a.toml", "--format", "json"});
  EXPECT_TRUE(f.code == 0 || f.code == 3) << f.code << f.err;
  EXPECT_TRUE(Json::accept(f.out));
}

TEST_F(RunCommand, ANegativeSeedIsRefusedAsItWasWritten) {
  write("a.toml", kOneLandmark);
  const Finished f = run({"run", "a.toml", "--seed", "-1"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("study.seed=-1"), std::string::npos) << f.err;
}

TEST_F(RunCommand, NamesReachTheTerminalWithoutTheirEscapes) {
  const std::string red = "\x1b[31m", reversed = "\xE2\x80\xAE";
  write(red + reversed + ".toml", kOneLandmark);
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

TEST_F(RunCommand, ScenariosOfOneNameAreRefusedBeforeTheyAreRun) {
  fs::create_directories(folder_ / "b");
  write("a.toml", kOneLandmark);
  write("b/a.toml", kOneLandmark);
  write("...toml", kOneLandmark);
  const Finished same = run({"run", "a.toml", "b/a.toml", "--out", "out"});
  EXPECT_EQ(same.code, 2);
  EXPECT_NE(same.err.find("b/a.toml: another scenario is called a"), std::string::npos) << same.err;
  EXPECT_EQ(run({"run", "a.toml", "...toml", "--out", "out"}).code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  EXPECT_FALSE(fs::exists(folder_ / "results.sqlite"));
}

TEST_F(RunCommand, MoreStepsThanCanBeStoredAreRefusedBeforeTheyAreMade) {
  write("a.toml", kOneLandmark);
  const Finished f = run({"sweep", "a.toml", "--runs", "1", "--steps", "4000000", "--out", "out"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("a.toml: study.steps = 4000000: at most"), std::string::npos) << f.err;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(RunCommand, ADiffusePriorWithMissedMeasurementsIsReported) {
  write("a.toml", kOneLandmark +
                      "[noise]\ndetection_probability = 0.5\ninitial_variance = 1e10\n"
                      "measurement_variance = 1e-6\n");
  for (const char* run_number : {"0", "17"}) {
    const Finished one = run({"run", "a.toml", "--only-run", run_number, "--format", "json"});
    EXPECT_TRUE(one.code == 0 || one.code == 3) << one.code << one.err;
    EXPECT_TRUE(Json::accept(one.out));
  }
  const Finished f = run({"run", "a.toml", "--steps", "50", "--format", "json"});
  EXPECT_TRUE(f.code == 0 || f.code == 3) << f.code << f.err;
  EXPECT_TRUE(Json::accept(f.out));
}

}  // namespace
}  // namespace credence::internal
