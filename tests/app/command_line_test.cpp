// The commands as a user types them: the built binary, its output, its exit codes.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class CommandLine : public CommandTest {
 protected:
  /// Until chunks have been written to the store of this folder.
  static void wait_for_chunks(const fs::path& folder) {
    const auto written = [&] {
      std::error_code none;
      const std::uintmax_t size = fs::file_size(folder / "results.sqlite-wal", none);
      return !none && size > 60000;
    };
    for (int i = 0; i < 30000 && !written(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};

const std::string kMonobot = "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 300\nsteps = 30\n";
const std::string kSweep =
    "[world]\nmodel = \"monobot\"\n[study]\nruns = 200\nsteps = 30\n[sweep]\n\"world.landmarks\" = \"1:3\"\n"
    "\"filter.inflation\" = \"none, map\"\n";

TEST_F(CommandLine, RunGivesTheDocumentOfTheContract) {
  write("a.toml", kMonobot);
  const Finished f = run({"run", "a.toml", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["runs"], 300);
  EXPECT_EQ(j["steps"], 30);
  EXPECT_EQ(j["state_dim"], 3);
  for (const char* name : {"nees", "nis"}) {
    EXPECT_EQ(j[name]["per_step"].size(), 30U);
    EXPECT_EQ(j["exact"][name].size(), 30U);
    EXPECT_EQ(j[name]["verdict"], "consistent");
    EXPECT_LT(j[name]["bounds"]["lower"], j[name]["expected"]);
    EXPECT_GT(j[name]["bounds"]["upper"], j[name]["expected"]);
    for (const char* key : {"mean", "share_outside", "p_value"}) EXPECT_TRUE(j[name][key].is_number());
  }
  for (const char* name : {"trace_prior", "trace", "vehicle", "landmarks"}) {
    EXPECT_EQ(j["covariance"][name].size(), 30U);
  }
  EXPECT_EQ(j["gain"].size(), 3U);
  EXPECT_EQ(j["outcomes"]["ok"], 300);
  EXPECT_EQ(j["outcomes"]["diverged"], 0);
  EXPECT_EQ(j["outcomes"]["not_positive_definite"], 0);
  EXPECT_EQ(f.err, "");
}

TEST_F(CommandLine, SameBitsForAnyNumberOfThreads) {
  write("a.toml", kMonobot);
  write("p.toml", "[world]\nmodel = \"planar\"\nlandmarks = 3\n[study]\nruns = 150\nsteps = 20\n");
  for (const char* scenario : {"a.toml", "p.toml"}) {
    const std::string one = run({"run", scenario, "--format", "json", "--threads", "1"}).out;
    ASSERT_GT(one.size(), 1000U);
    for (const char* threads : {"2", "3", "7"}) {
      EXPECT_EQ(run({"run", scenario, "--format", "json", "--threads", threads}).out, one) << threads;
    }
  }
}

TEST_F(CommandLine, AMistunedFilterIsFoundOut) {
  write("a.toml", kMonobot);
  const auto verdict = [&](const char* scale) {
    const Finished f =
        run({"run", "a.toml", "--format", "json", "--set", std::string("filter.measurement_scale=") + scale});
    return Json::parse(f.out)["verdict"].get<std::string>();
  };
  EXPECT_EQ(verdict("0.5"), "optimistic");
  EXPECT_EQ(verdict("1.0"), "consistent");
  EXPECT_EQ(verdict("2.0"), "pessimistic");
  EXPECT_EQ(run({"run", "a.toml", "--set", "filter.measurement_scale=2.0", "--fail-on-inconsistent"}).code,
            1);
}

TEST_F(CommandLine, ASweepSurvivesKill9WithTheSameBits) {
  write("s.toml", kSweep);
  const Finished whole = run({"sweep", "s.toml", "--out", "whole", "--format", "json", "--runs", "100000"});
  ASSERT_EQ(whole.code, 0) << whole.err;

  const pid_t child =
      start({"sweep", "s.toml", "--out", "killed", "--format", "json", "--runs", "100000", "--threads", "1"});
  wait_for_chunks(folder_ / "killed");
  ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "the sweep was over before it could be killed";
  kill(child, SIGKILL);
  EXPECT_EQ(finish(child).code, 128 + SIGKILL);
  const Finished resumed =
      run({"sweep", "s.toml", "--out", "killed", "--format", "json", "--runs", "100000"});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(resumed.out, whole.out);
}

TEST_F(CommandLine, CtrlCSavesReportsWhatIsThereAndExits130) {
  write("a.toml", kMonobot);
  const pid_t child =
      start({"run", "a.toml", "--runs", "100000000", "--out", "out", "--threads", "1", "--format", "json"});
  wait_for_chunks(folder_ / "out");
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["complete"], false);
  EXPECT_GT(j["runs"], 0);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "results.sqlite"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "index.html"));
}

TEST_F(CommandLine, AStopRuleEndsAStudyAtTheFirstProofAndAlwaysAtTheSameRun) {
  write("wrong.toml",
        "[world]\nmodel = \"monobot\"\n[filter]\nmeasurement_scale = 0.5\n[study]\nsteps = 30\n"
        "stop = { verdict = \"either\", consistent_within = 0.2, max_runs = 100000 }\n");
  const Finished one = run({"run", "wrong.toml", "--format", "json", "--threads", "1"});
  const Finished two = run({"run", "wrong.toml", "--format", "json", "--threads", "2"});
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_EQ(one.out, two.out);
  const Json j = Json::parse(one.out);
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_EQ(j["stop"]["reason"], "verdict");
  EXPECT_LT(j["stop"]["p_value"], 0.025);
  EXPECT_LT(j["runs"], 1000);
  EXPECT_EQ(j["scenario"]["study"]["stop"]["max_runs"], 100000);

  const Finished right =
      run({"run", "wrong.toml", "--set", "filter.measurement_scale=1.0", "--format", "json"});
  const Json k = Json::parse(right.out);
  EXPECT_EQ(k["verdict"], "consistent");
  EXPECT_GE(k["stop"]["scale"]["lower"], 1.0 / 1.2);
  EXPECT_LE(k["stop"]["scale"]["upper"], 1.2);
  EXPECT_EQ(run({"run", "wrong.toml", "--set", "study.stop.verdict=\"no\""}).code, 2);
  EXPECT_EQ(run({"sweep", "wrong.toml", "--shard", "1/2", "--out", "part"}).code, 2);
}

TEST_F(CommandLine, PointsOfASweepInAnotherOrderGiveTheSameDocument) {
  write("s.toml", kSweep);
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

TEST_F(CommandLine, ShardsMergedAreTheWhole) {
  write("s.toml", kSweep);
  const Finished whole = run({"sweep", "s.toml", "--out", "whole", "--format", "json"});
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "1/2", "--out", "p1"}).code, 0);
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "2/2", "--out", "p2"}).code, 0);
  EXPECT_EQ(run({"merge", "p1", "p2", "--out", "joined"}).code, 0);
  const Finished joined = run({"sweep", "s.toml", "--out", "joined", "--format", "json"});
  EXPECT_EQ(joined.out, whole.out);
  EXPECT_EQ(run({"sweep", "s.toml", "--shard", "3/2", "--out", "p3"}).code, 2);
}

TEST_F(CommandLine, AChangedScenarioIsRefusedWithTheDifference) {
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

TEST_F(CommandLine, ReportsAreCompleteAndFiguresAreThere) {
  write("a.toml", kMonobot);
  const Finished f = run({"run", "a.toml", "--out", "out"});
  ASSERT_EQ(f.code, 0) << f.err;
  const std::string page = read("out/index.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "a.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "a-run.pdf"));
}

TEST_F(CommandLine, ALinearStudySaysWhatTheoryGives) {
  write("a.toml", kMonobot);
  const std::vector<std::string> wrong{"run", "a.toml", "--set", "filter.process_scale=0.25"};
  std::vector<std::string> json = wrong;
  json.insert(json.end(), {"--format", "json"});
  const Json j = Json::parse(run(json).out);
  double nees = 0.0;
  for (const double value : j.at("exact").at("nees")) nees += value;
  const Finished text = run(wrong);
  const std::string says = "theory gives mean NEES ";
  const std::size_t at = text.out.find(says);
  ASSERT_NE(at, std::string::npos) << text.out;
  const double said = std::stod(text.out.substr(at + says.size()));
  EXPECT_NEAR(said, nees / static_cast<double>(j.at("exact").at("nees").size()), 5e-4 * said);
  EXPECT_GT(said, 1.1 * 3.0) << "and not what a consistent filter has";
}

TEST_F(CommandLine, FiguresForAPaperAreMadeFromWhatIsStored) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  const Finished f = run({"report", "out", "--figures", "pgf,png,one-column"});
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "panels" / "a-run-2.pgf"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "a-run.png"));
  EXPECT_NE(read("out/index.html").find("a-run.pgf\">PGF</a>"), std::string::npos);
  const Finished word = run({"report", "out", "--figures", "eps"});
  EXPECT_EQ(word.code, 2);
  EXPECT_NE(word.err.find("one-column"), std::string::npos) << "what is accepted: " << word.err;
  const Finished widths = run({"run", "a.toml", "--figures", "one-column,two-columns", "--out", "none"});
  EXPECT_EQ(widths.code, 2);
  EXPECT_NE(widths.err.find("one-column and two-columns exclude each other"), std::string::npos)
      << widths.err;
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

TEST_F(CommandLine, ASingleRunIsReplayedAlone) {
  write("a.toml", kMonobot);
  const Finished f = run({"run", "a.toml", "--only-run", "17", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["run"], 17);
  EXPECT_EQ(j["steps"].size(), 31U);
  EXPECT_EQ(j["steps"][30]["covariance"].size(), 3U);
  EXPECT_EQ(run({"run", "a.toml", "--only-run", "17"}).code, 0);
  EXPECT_EQ(run({"run", "a.toml", "--only-run", "-1"}).code, 2);
}

TEST_F(CommandLine, FailedRunsAreNamedAndExitWith3) {
  write("a.toml",
        "[world]\nmodel = \"monobot\"\n[noise]\nmeasurement_variance = 0\nprocess_variance = 0\n"
        "initial_variance = 0\n[study]\nruns = 3\nsteps = 2\n");
  const Finished f = run({"run", "a.toml", "--format", "json"});
  EXPECT_EQ(f.code, 3) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["outcomes"]["not_positive_definite"], 3);
  EXPECT_EQ(j["outcomes"]["failures"][2]["run"], 2);
  EXPECT_EQ(j["outcomes"]["failures"][2]["step"], 1);
  EXPECT_TRUE(j["nees"]["mean"].is_null());
}

/// What is wrong, the scenario text, and words that the one message must contain.
struct Bad {
  const char* what;
  std::string text;
  std::vector<std::string> words;
};

TEST_F(CommandLine, SelftestGivesARateForEveryTest) {
  const Finished f = run({"selftest", "--studies", "100", "--format", "json", "--out", "st"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_TRUE(j["ok"]);
  EXPECT_GT(j["tests"].size(), 50U);
  for (const Json& test : j["tests"]) {
    EXPECT_TRUE(test["ok"]) << test;
    EXPECT_TRUE(test["nominal"] == 0.05 || test["nominal"].get<double>() < 0.011) << test;
    EXPECT_LE(test["lower"], test["measured"]) << test;
    EXPECT_GE(test["upper"], test["measured"]) << test;
    EXPECT_LE(test["lower"], test["nominal"]) << test;
  }
  ASSERT_EQ(j["wrong_filters"].size(), 13U);
  for (const Json& filter : j["wrong_filters"]) {
    EXPECT_TRUE(filter["ok"]) << filter["filter"];
    EXPECT_GT(filter["power"].size(), 15U) << filter["filter"];
  }
  EXPECT_GT(j["naive"][0]["measured"], 0.4);
  EXPECT_NE(read("st/index.html").find("<svg"), std::string::npos);
}

TEST_F(CommandLine, SelftestInterruptedProvesNothing) {
  const pid_t child = start({"selftest", "--studies", "1000000"});
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.out, "");
  EXPECT_NE(f.err.find("interrupted"), std::string::npos);
}

TEST_F(CommandLine, PlanGivesRunsForBothDirections) {
  write("a.toml", kMonobot);
  const Finished f = run({"plan", "a.toml", "--factor", "1.5", "--power", "0.8", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  for (const char* name : {"nees", "nis"}) {
    ASSERT_EQ(j[name]["detect"].size(), 2U);
    EXPECT_EQ(j[name]["detect"][0]["factor"], 1.5);
    for (const Json& detection : j[name]["detect"]) {
      EXPECT_GE(detection["power"], 0.8);
      EXPECT_GE(detection["runs"], 1);
      EXPECT_LE(detection["runs"], j["runs"]);
    }
  }
  EXPECT_EQ(j["nees"]["effective_steps_from"], "exact law");
  EXPECT_GT(j["seconds"], 0.0);
  EXPECT_GE(j["precision"]["runs"], 2);
  EXPECT_NE(run({"plan", "a.toml"}).out.find("NEES verdict"), std::string::npos);
  EXPECT_EQ(run({"plan", "a.toml", "--factor", "1"}).code, 2);
}

TEST_F(CommandLine, PlanOfASweepIsTheCostOfAllOfIt) {
  write("s.toml", kSweep);
  const Finished f = run({"plan", "s.toml", "--factor", "2", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["sweep"]["configurations"], 6);
  EXPECT_EQ(j["sweep"]["planned"], 6);
  EXPECT_EQ(j["configurations"].size(), 6U);
  EXPECT_GT(j["sweep"]["seconds"], 0.0);
  EXPECT_NE(run({"plan", "s.toml", "--factor", "2"}).out.find("The sweep of 6 configurations"),
            std::string::npos);
}

TEST_F(CommandLine, EveryMalformedScenarioEndsWith2AndOneMessage) {
  const std::vector<Bad> cases = {
      {"unknown key",
       "[world]\nmodel = \"monobot\"\nlandmark = 2\n",
       {"bad.toml:3", "landmark", "landmarks"}},
      {"unknown table", "[word]\nmodel = \"monobot\"\n", {"bad.toml:", "word", "world"}},
      {"wrong type", "[world]\nmodel = \"monobot\"\nlandmarks = \"two\"\n", {"bad.toml:3", "landmarks"}},
      {"negative variance",
       "[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = -1\n",
       {"bad.toml:4", "process_variance", "-1"}},
      {"not a number",
       "[world]\nmodel = \"monobot\"\n[noise]\nprocess_variance = nan\n",
       {"bad.toml:4", "process_variance"}},
      {"zero runs", "[world]\nmodel = \"monobot\"\n[study]\nruns = 0\n", {"bad.toml:4", "runs"}},
      {"unknown word", "[world]\nmodel = \"submarine\"\n", {"bad.toml:2", "model", "monobot", "planar"}},
      {"broken TOML", "[world\nmodel = \"monobot\"\n", {"bad.toml:1"}},
  };
  for (const Bad& bad : cases) {
    write("bad.toml", bad.text);
    for (const char* command : {"run", "sweep"}) {
      const Finished f = run({command, "bad.toml", "--out", "never"});
      EXPECT_EQ(f.code, 2) << bad.what;
      EXPECT_EQ(f.out, "") << bad.what;
      for (const std::string& word : bad.words)
        EXPECT_NE(f.err.find(word), std::string::npos) << bad.what << ": " << f.err;
      EXPECT_FALSE(fs::exists(folder_ / "never")) << bad.what;
    }
  }
  EXPECT_EQ(run({"run", "missing.toml"}).code, 2);
  EXPECT_EQ(run({"run"}).code, 2);
  EXPECT_EQ(run({"jump"}).code, 2);
  EXPECT_EQ(run({"run", "--help"}).code, 0);
  EXPECT_NE(run({"help", "scenario"}).out.find("measurement_scale"), std::string::npos)
      << "help lists the keys";
}

TEST_F(CommandLine, AFullDiskBehindTheOutputIsAnError) {
  write("a.toml", kMonobot);
  fs::create_symlink("/dev/full", folder_ / "stdout");
  for (const char* format : {"text", "json"}) {
    int status = 0;
    waitpid(start({"run", "a.toml", "--format", format}), &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 2) << format;
    EXPECT_NE(read("stderr").find("credence: "), std::string::npos) << format;
  }
}

TEST_F(CommandLine, MissedMeasurementsGiveEveryRunItsOwnCovariance) {
  write("a.toml", kMonobot);
  const Json optimal =
      json({"run", "a.toml", "--set", "noise.detection_probability=0.5", "--format", "json"});
  EXPECT_EQ(optimal["nees"]["verdict"], "consistent");
  EXPECT_EQ(optimal["exact"]["nees"], Json(std::vector<double>(30, 3.0)));
  for (const double nis : optimal["exact"]["nis"]) EXPECT_NEAR(nis, 4.0 / 3.0, 1e-15);
  EXPECT_TRUE(optimal["gain"].is_null());
  EXPECT_TRUE(optimal["gain_reason"].is_string());
  EXPECT_NEAR(optimal["nis"]["expected"].get<double>(), 4.0 / 3.0, 0.02);
  const Json logged = json(
      {"run", "a.toml", "--set", "noise.detection_probability=0.5", "--log", "logs", "--format", "json"});
  EXPECT_NEAR(logged["nis"]["mean"].get<double>(), optimal["nis"]["mean"].get<double>(), 1e-12);
  EXPECT_NEAR(logged["nees"]["mean"].get<double>(), optimal["nees"]["mean"].get<double>(), 1e-12);
  const Json wrong = json({"run", "a.toml", "--set", "noise.detection_probability=0.5", "--set",
                           "filter.measurement_scale=0.3", "--runs", "1000", "--format", "json"});
  EXPECT_EQ(wrong["nees"]["verdict"], "optimistic");
  EXPECT_TRUE(wrong["exact"]["nees"].empty());
  EXPECT_TRUE(wrong["exact_reason"].is_string());
}

TEST_F(CommandLine, AnOutputThatCannotBeWrittenIsAnErrorThatNamesIt) {
  write("a.toml", kMonobot);
  write("file", "not a folder");
  const Finished f = run({"run", "a.toml", "--out", "file/out"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("file/out"), std::string::npos) << f.err;
  EXPECT_EQ(read("file"), "not a folder");
}

}  // namespace
}  // namespace credence::internal
