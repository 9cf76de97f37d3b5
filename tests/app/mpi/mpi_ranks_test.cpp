// Several processes under mpirun, as a user starts them. Skipped where the program was built without MPI.

#include <gtest/gtest.h>

#include <charconv>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

const std::string kRanksSweep =
    "[world]\nmodel = \"planar\"\nlandmarks = 5\n[study]\nruns = 500\nsteps = 60\n"
    "[sweep]\n\"filter.measurement_scale\" = [0.5, 1.0]\n";

class MpiRanks : public CommandTest {
 protected:
  void SetUp() override {
    if (!fs::exists(fs::path(credence_binary()).parent_path() / "libcredence_mpi.so")) {
      GTEST_SKIP() << "built without MPI";
    }
    if (std::system("command -v mpirun > /dev/null") != 0) GTEST_SKIP() << "there is no mpirun";
    setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 1);  // not allowed in many containers
    write("s.toml", kRanksSweep);
  }

  pid_t start_ranks(int count, std::vector<std::string> arguments) const {
    // MPI itself leaks; a sanitizer shall look at the program without it.
    std::vector<std::string> all{
        "mpirun", "--allow-run-as-root", "--oversubscribe", "-x", "ASAN_OPTIONS=detect_leaks=0",
        "-n",     std::to_string(count), credence_binary()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return start_program(all);
  }

  Finished ranks(int count, const std::vector<std::string>& arguments) const {
    return finish(start_ranks(count, arguments));
  }

  /// The process of this rank that works in the folder of the test.
  pid_t process_of(int rank) const {
    const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank);
    for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
      const std::string name = entry.path().filename();
      pid_t process = 0;
      if (std::from_chars(name.data(), name.data() + name.size(), process).ec != std::errc{}) continue;
      std::error_code none;
      if (fs::read_symlink(entry.path() / "cwd", none) != fs::canonical(folder_.path())) continue;
      std::ifstream environment(entry.path() / "environ", std::ios::binary);
      for (std::string variable; std::getline(environment, variable, '\0');) {
        if (variable == wanted) return process;
      }
    }
    return 0;
  }

  /// What merge says of two folders: the chunks of the second are there already, with the same bits.
  std::string merged(const std::string& first, const std::string& second) const {
    fs::remove_all(folder_ / "joined");
    const Finished f = run({"merge", first, second, "--out", "joined"});
    return f.code == 0 ? f.out : f.err;
  }

  static std::string all_there(const std::string& first, const std::string& second, int chunks) {
    return first + ": " + std::to_string(chunks) + " chunks added, 0 there already\n" + second +
           ": 0 chunks added, " + std::to_string(chunks) + " there already\n";
  }
};

TEST_F(MpiRanks, SweepHasTheSameBitsForAnyNumberOfRanks) {
  const Finished alone = run({"sweep", "s.toml", "--out", "o1", "--format", "json"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  for (const int count : {1, 2, 3, 8}) {
    const std::string folder = "ranks" + std::to_string(count);
    const Finished f = ranks(count, {"sweep", "s.toml", "--out", folder, "--format", "json"});
    EXPECT_EQ(f.code, 0) << f.err;
    EXPECT_EQ(f.out, alone.out) << count;
    EXPECT_EQ(merged("o1", folder), all_there("o1", folder, 16));
  }
}

TEST_F(MpiRanks, AStopRuleEndsWhereItEndsAlone) {
  write("r.toml",
        "[world]\nmodel = \"monobot\"\n[study]\nruns = 20000\nsteps = 20\n"
        "[study.stop]\nprecision = 0.05\n");
  const Finished alone = run({"run", "r.toml", "--format", "json"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_EQ(ranks(3, {"run", "r.toml", "--format", "json"}).out, alone.out);
}

TEST_F(MpiRanks, AKilledRankLosesNothing) {
  const pid_t job = start_ranks(3, {"sweep", "s.toml", "--runs", "1000000", "--out", "cut"});
  wait_for([&] {
    std::error_code none;
    return fs::file_size(folder_ / "cut/results.sqlite-wal", none) > 60000 && !none;
  });
  const pid_t victim = process_of(2);
  ASSERT_GT(victim, 0);
  kill(victim, SIGKILL);
  EXPECT_NE(finish(job).code, 0);
  // With fewer runs, so that it ends: of them most are there.
  const Finished whole = run({"sweep", "s.toml", "--out", "whole", "--format", "json"});
  EXPECT_EQ(ranks(2, {"sweep", "s.toml", "--out", "cut", "--format", "json"}).out, whole.out);
  const std::string counts = merged("whole", "cut");
  EXPECT_NE(counts.find("cut: "), std::string::npos) << counts;
  EXPECT_EQ(counts.find("cut: 0 chunks added, 16 there"), std::string::npos)
      << "nothing was there: " << counts;
}

TEST_F(MpiRanks, EstimatorsSayTheSame) {
  const std::vector<std::string> compared{"estimators", "ukfm_slam2d", "--runs", "20",           "--steps",
                                          "40",         "--format",    "json",   "--estimators", "ekf,ideal"};
  Json alone = json(compared);
  Json shared = Json::parse(ranks(3, compared).out);
  for (Json* document : {&alone, &shared}) {
    for (Json& row : document->at("rows")) row.erase("seconds_per_step");  // measured
  }
  EXPECT_EQ(alone, shared);
}

TEST_F(MpiRanks, WhatIsWrongIsSaidOnce) {
  const Finished f = ranks(3, {"run", "nowhere.toml"});
  EXPECT_EQ(f.code, 2);
  const std::size_t first = f.err.find("nowhere.toml: no such scenario file");
  ASSERT_NE(first, std::string::npos) << f.err;
  EXPECT_EQ(f.err.find("no such scenario file", first + 20), std::string::npos) << f.err;
  EXPECT_NE(ranks(2, {"run", "s.toml", "--log", "logs"}).err.find("--log: one process writes the logs"),
            std::string::npos);
  EXPECT_EQ(ranks(2, {"explain", "NEES"}).out, run({"explain", "NEES"}).out);
}

}  // namespace
}  // namespace credence::internal
