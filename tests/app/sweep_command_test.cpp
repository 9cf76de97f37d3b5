// `credence sweep` and `credence merge` as a user types them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "montecarlo/engine/result_store_sqlite.h"
#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class SweepCommand : public CommandTest {};

TEST_F(SweepCommand, ASweepSurvivesKill9WithTheSameBits) {
  write("s.toml", kMonobotSweep);
  const Finished whole = run({"sweep", "s.toml", "--out", "whole", "--format", "json", "--runs", "100000"});
  ASSERT_EQ(whole.code, 0) << whole.err;

  const pid_t child =
      start({"sweep", "s.toml", "--out", "killed", "--format", "json", "--runs", "100000", "--threads", "1"});
  wait_for_chunks("killed");
  ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "the sweep was over before it could be killed";
  kill(child, SIGKILL);
  EXPECT_EQ(finish(child).code, 128 + SIGKILL);
  const Finished resumed =
      run({"sweep", "s.toml", "--out", "killed", "--format", "json", "--runs", "100000"});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(resumed.out, whole.out);
}

TEST_F(SweepCommand, PointsOfASweepInAnotherOrderGiveTheSameDocument) {
  write("s.toml", kMonobotSweep);
  write("t.toml",
        "[world]\nmodel = \"monobot\"\n[study]\nruns = 200\nsteps = 30\n[sweep]\n\"filter.inflation\" = "
        "[\"map\", "
        "\"none\"]\n\"world.landmarks\" = [3, 1, 2]\n");
  fs::create_directory(folder_ / "other");
  fs::rename(folder_ / "t.toml", folder_ / "other" / "s.toml");
  const Finished a = run({"sweep", "s.toml", "--out", "a", "--format", "json"});
  const Finished b = run({"sweep", "other/s.toml", "--out", "b", "--format", "json"});
  ASSERT_EQ(a.code, 0) << a.err;
  EXPECT_EQ(a.out, b.out);
  EXPECT_EQ(Json::parse(a.out)["configurations"].size(), 6U);
}

TEST_F(SweepCommand, ShardsMergedAreTheWhole) {
  write("s.toml", kMonobotSweep);
  const Finished whole = run({"sweep", "s.toml", "--out", "whole", "--format", "json"});
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "1/2", "--out", "p1"}).code, 0);
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "2/2", "--out", "p2"}).code, 0);
  EXPECT_EQ(run({"merge", "p1", "p2", "--out", "joined"}).code, 0);
  const Finished joined = run({"sweep", "s.toml", "--out", "joined", "--format", "json"});
  EXPECT_EQ(joined.out, whole.out);
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "3/2", "--out", "p3"}).code, 2);
}

TEST_F(SweepCommand, SweepResumesAndCheckJudgesTheLogs) {
  const std::vector<std::string> sweep = {"sweep",    scenario_file("linear"),
                                          "--runs",   "64",
                                          "--set",    "study.steps=10",
                                          "--set",    "sweep.filter.process_scale=0.5,1,2",
                                          "--out",    "out",
                                          "--format", "json"};
  const Json first = json(sweep), again = json(sweep);
  EXPECT_EQ(first, again);
  EXPECT_EQ(
      run({"run", scenario_file("tracking"), "--runs", "64", "--set", "study.steps=20", "--log", "logs"})
          .code,
      0);
  const Json judged = json({"check", "logs", "--format", "json"});
  EXPECT_NEAR(judged["nees"]["mean"].get<double>(),
              json({"run", scenario_file("tracking"), "--runs", "64", "--set", "study.steps=20", "--format",
                    "json"})["nees"]["mean"]
                  .get<double>(),
              1e-9);
}

TEST_F(SweepCommand, AShardIsOneOfSoMany) {
  write("s.toml", kMonobotSweep);
  for (const std::string shard : {"3/2", "0/2", "-1/2", "1", "a/b", "1/2x", "1/", "/2", "1/99999999999"}) {
    const Finished f = run({"sweep", "s.toml", "--shard", shard, "--out", "never"});
    EXPECT_EQ(f.code, 2) << shard;
    EXPECT_EQ(f.err, "credence: --shard " + shard + ": accepted are i/n with 1 <= i <= n, as in 2/4\n");
  }
  EXPECT_FALSE(fs::exists(folder_ / "never"));
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "2/2", "--out", "part"}).err,
            "Shard 2/2 is stored in part; join with credence merge\n");
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "2/2", "--out", "part"}).out, "") << "no verdict on a part";
}

TEST_F(SweepCommand, AShardTellsWhatItHasDoneAsJson) {
  write("s.toml", kMonobotSweep);
  std::map<std::string, std::int64_t> runs;
  for (const char* shard : {"1/2", "2/2"}) {
    const Finished f =
        run({"sweep", "s.toml", "--shard", shard, "--out", std::string("p") + shard[0], "--format", "json"});
    EXPECT_EQ(f.code, 0) << f.err;
    const Json j = Json::parse(f.out);
    EXPECT_EQ(j["points"], 6);
    EXPECT_EQ(j["configurations"], Json::array()) << "no verdict on a part";
    const Json& part = j["shard"];
    EXPECT_EQ(part["of"], 2);
    EXPECT_EQ(part["directory"], std::string("p") + shard[0]);
    EXPECT_EQ(part["complete"], true);
    EXPECT_EQ(part["remaining"], 0);
    ASSERT_EQ(part["configurations"].size(), 6U);
    std::int64_t sum = 0;
    for (const Json& each : part["configurations"]) {
      EXPECT_TRUE(each["swept"].contains("world.landmarks"));
      runs[each["configuration"]] += each["runs"].get<std::int64_t>();
      sum += each["runs"].get<std::int64_t>();
    }
    EXPECT_EQ(part["runs"], sum);
  }
  ASSERT_EQ(runs.size(), 6U);
  for (const auto& [configuration, sum] : runs) EXPECT_EQ(sum, 200) << configuration;
}

TEST_F(SweepCommand, AShardThatIsInterruptedTellsWhatRemains) {
  write("s.toml", kMonobotSweep);
  const std::vector<std::string> shard = {"sweep",  "s.toml",  "--shard",  "2/2",  "--out",     "part",
                                          "--runs", "1000000", "--format", "json", "--threads", "1"};
  const pid_t child = start(shard);
  wait_for_chunks("part");
  kill(child, SIGINT);
  const Finished f = finish(child);
  ASSERT_EQ(f.code, 130) << "over before it could be interrupted";
  const Json part = Json::parse(f.out)["shard"];
  EXPECT_EQ(part["complete"], false);
  EXPECT_GT(part["runs"], 0);
  std::int64_t stored = 0;
  const SqliteDatabase store(folder_ / "part/results.sqlite", SqliteDatabase::Mode::read);
  stored = store.integer("SELECT sum(runs) FROM chunks");
  EXPECT_EQ(part["runs"], stored);
  EXPECT_EQ(part["runs"].get<std::int64_t>() + part["remaining"].get<std::int64_t>(), 3'000'000);
}

TEST_F(SweepCommand, WithoutAFolderItHasOneOfItsOwnForEachPlan) {
  write("s.toml", kMonobotSweep);
  const auto folders = [&] { return std::distance(fs::directory_iterator(folder_ / "out"), {}); };
  const Finished first = run({"sweep", "s.toml", "--runs", "64", "--format", "json"});
  EXPECT_THAT(first.err, ::testing::MatchesRegex("Report: out/s-[0-9a-f]{8}/index.html\n"));
  const Finished again = run({"sweep", "s.toml", "--runs", "64", "--format", "json"});
  EXPECT_EQ(again.out, first.out);
  EXPECT_EQ(again.err, first.err);
  EXPECT_EQ(folders(), 1);
  EXPECT_EQ(run({"sweep", "s.toml", "--runs", "64", "--set", "noise.process_variance=0.2"}).code, 0);
  EXPECT_EQ(folders(), 2);
}

TEST_F(SweepCommand, MergeRefusesWhatDoesNotBelongTogether) {
  write("s.toml", kMonobotSweep);
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"sweep", "s.toml", "--shard", "1/2", "--out", "part", "--quiet"}).code, 0);
  ASSERT_EQ(run({"run", "a.toml", "--out", "other", "--quiet"}).code, 0);
  const Finished missing = run({"merge", "part", "nowhere", "--out", "joined"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_EQ(missing.err, "credence: nowhere: holds no results (there is no results.sqlite)\n");
  EXPECT_FALSE(fs::exists(folder_ / "joined")) << "it is seen before anything is made";
  const Finished other = run({"merge", "part", "other", "--out", "joined"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, ::testing::StartsWith("credence: other: holds results of another scenario than part "
                                               "(- of part, + of other):\n"));
  EXPECT_THAT(other.err,
              ::testing::HasSubstr("\n- sweep.world.landmarks = [1, 2, 3]\n+ world.landmarks = 2\n"));
  EXPECT_THAT(other.err, ::testing::EndsWith("\nthey cannot be joined\n"));
  EXPECT_FALSE(fs::exists(folder_ / "joined")) << "this is seen before anything is made, too";
  // Again, and the same part twice: all is there already.
  EXPECT_EQ(run({"merge", "part", "part", "--out", "joined"}).out,
            "part: 12 chunks added, 0 there already\npart: 0 chunks added, 12 there already\n");
  EXPECT_EQ(run({"merge", "part", "--out", "joined"}).out, "part: 0 chunks added, 12 there already\n");
}

TEST_F(SweepCommand, AMergeThatFailsOnTheWayLeavesNothingThatWasNotThere) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "good", "--quiet"}).code, 0);
  ASSERT_EQ(run({"run", "a.toml", "--out", "bad", "--quiet"}).code, 0);
  {
    SqliteDatabase store(folder_ / "bad/results.sqlite", SqliteDatabase::Mode::create);
    store.execute("UPDATE chunks SET checksum = checksum + 1 WHERE first_run = 64");
  }
  EXPECT_THAT(run({"merge", "good", "bad", "--out", "new/joined"}).err,
              ::testing::HasSubstr("their checksum does not fit"));
  EXPECT_FALSE(fs::exists(folder_ / "new"));
  fs::create_directory(folder_ / "empty");
  EXPECT_EQ(run({"merge", "bad", "--out", "empty"}).code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "empty/results.sqlite"));
  ASSERT_EQ(run({"merge", "good", "--out", "empty"}).code, 0);
  EXPECT_EQ(run({"merge", "bad", "--out", "empty"}).code, 2);
  EXPECT_EQ(json({"show", "empty", "--format", "json"})["runs"], 300) << "what was there stays";
}

// One of them fails after what the other has made, or both do: of `damaged`, which is seen on the way.
TEST_F(SweepCommand, MergesIntoOneNewFolderAtATimeLoseNothing) {
  write("a.toml", kMonobot);
  for (const char* folder : {"good", "damaged"}) {
    ASSERT_EQ(run({"run", "a.toml", "--out", folder, "--quiet"}).code, 0);
  }
  {
    SqliteDatabase store(folder_ / "damaged/results.sqlite", SqliteDatabase::Mode::create);
    store.execute("UPDATE chunks SET checksum = checksum + 1 WHERE first_run = 256");
  }
  int joined = 0;
  for (int round = 0; round < 30; ++round) {
    const pid_t good = start({"merge", "good", "--out", "new/joined"});
    const pid_t damaged = start({"merge", "damaged", "--out", "new/joined"});
    EXPECT_EQ(finish(damaged).code, 2);
    const bool done = finish(good).code == 0;
    EXPECT_EQ(fs::exists(folder_ / "new/joined/results.sqlite"), done) << round;
    if (done) EXPECT_EQ(json({"show", "new/joined", "--format", "json"})["runs"], 300) << round;
    joined += done ? 1 : 0;
    fs::remove_all(folder_ / "new");
  }
  EXPECT_GT(joined, 0);
}

TEST_F(SweepCommand, OfAScenarioWithoutASweepItHasOneConfiguration) {
  write("a.toml", kMonobot);
  const Json swept = json({"sweep", "a.toml", "--out", "out", "--format", "json", "--quiet"});
  ASSERT_EQ(swept["configurations"].size(), 1U);
  EXPECT_EQ(swept["configurations"][0]["nees"]["mean"],
            json({"run", "a.toml", "--format", "json"})["nees"]["mean"]);
}

TEST_F(SweepCommand, SweepSaysThatThereIsNone) {
  write("a.toml", kMonobot);
  const std::string none =
      "a.toml has no [sweep] that varies a key, so that this is its one configuration, as credence run "
      "a.toml plays it; to vary one: a [sweep] table, or --set sweep.SECTION.KEY=VALUES\n";
  EXPECT_EQ(run({"sweep", "a.toml", "--out", "none", "--quiet"}).err, none);
  EXPECT_EQ(run({"sweep", "a.toml", "--set", "sweep.mode=zip", "--out", "mode", "--quiet"}).err, none)
      << "a table that names no key";
  EXPECT_EQ(run({"sweep", "a.toml", "--set", "sweep.world.landmarks=1:2", "--out", "some", "--quiet"}).err,
            "");
}

}  // namespace
}  // namespace credence::internal
