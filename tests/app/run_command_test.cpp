// `credence run`: its document, its report, and what happens where something goes wrong.

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
using ::testing::Not;
namespace fs = std::filesystem;

const std::string kPlanar = "[world]\nmodel = \"planar\"\nlandmarks = 10\n[study]\nruns = 640\nsteps = 400\n";

class RunCommand : public CommandTest {};

TEST_F(RunCommand, RunGivesTheDocumentOfTheContract) {
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

// Its x2 is measured without noise; or P is said to know it, and does not.
TEST_F(RunCommand, WhatIsCertainIsNotJudgedAndWhatIsNotIsNamed) {
  const std::string model =
      "[world]\nmodel = \"linear\"\nF = [[1, 0.1], [0, 1]]\nG = [[0], [1]]\nH = [[1, 0], [0, 1]]\n"
      "Q = [[0.2]]\nP0 = [[1, 0], [0, 1]]\n";
  const std::string study = "[study]\nruns = 200\nsteps = 100\n";
  write("certain.toml", model + "R = [[0.3, 0], [0, 0]]\n" + study);
  for (const char* seed : {"study.seed=1", "study.seed=2", "study.seed=3"}) {
    const Finished f = run({"run", "certain.toml", "--set", seed});
    EXPECT_EQ(f.code, 0) << f.err;
    EXPECT_THAT(f.out, HasSubstr("No evidence that this covariance is wrong")) << seed;
    EXPECT_THAT(f.out, Not(HasSubstr("claims certainty"))) << seed;
  }
  write("wrong.toml",
        "[world]\nmodel = \"linear\"\nF = [[1, 0], [0, 1]]\nG = [[1], [0]]\nH = [[1, 0]]\nQ = [[0.2]]\n"
        "R = [[0.3]]\nP0 = [[1, 0], [0, 4]]\n[filter]\nP0 = [[1, 0], [0, 0]]\n" +
            study);
  const Finished f = run({"run", "wrong.toml"});
  EXPECT_THAT(f.out, HasSubstr("wrong is undecided: x2 errs in 20000 of 20000 rows where P claims certainty "
                               "(variance 0); what else is judged is consistent"));
  EXPECT_THAT(f.out,
              HasSubstr("of that of the errors is where it claims certainty, and there P is too small"));
  EXPECT_THAT(f.out, Not(HasSubstr("Proved")));
}

TEST_F(RunCommand, SameBitsForAnyNumberOfThreads) {
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

TEST_F(RunCommand, AMistunedFilterIsFoundOut) {
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

TEST_F(RunCommand, AStopRuleEndsAStudyAtTheFirstProofAndAlwaysAtTheSameRun) {
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

TEST_F(RunCommand, ALinearStudySaysWhatTheoryGives) {
  write("a.toml", kMonobot);
  const std::vector<std::string> wrong{"run", "a.toml", "--set", "filter.process_scale=0.25"};
  std::vector<std::string> json = wrong;
  json.insert(json.end(), {"--format", "json"});
  const Json j = Json::parse(run(json).out);
  double nees = 0.0;
  for (const double value : j.at("exact").at("nees")) nees += value;
  const Finished text = run(wrong);
  const std::string says = "Exact, without sampling noise: mean NEES ";
  const std::size_t at = text.out.find(says);
  ASSERT_NE(at, std::string::npos) << text.out;
  const double said = std::stod(text.out.substr(at + says.size()));
  EXPECT_NEAR(said, nees / static_cast<double>(j.at("exact").at("nees").size()), 5e-4 * said);
  EXPECT_GT(said, 1.1 * 3.0) << "and not what a consistent filter has";
}

TEST_F(RunCommand, RunHasTheExactMomentsOfALinearWorld) {
  for (const char* name : {"linear", "tracking"}) {
    const Json j =
        json({"run", scenario_file(name), "--runs", "64", "--set", "study.steps=20", "--format", "json"});
    EXPECT_EQ(j["exact"]["nees"].size(), 20U) << name;
    EXPECT_EQ(j["covariance"]["trace"].size(), 20U) << name;
    EXPECT_TRUE(j["covariance"]["landmarks"].empty()) << name;
    EXPECT_FALSE(j["gain"].empty()) << name;
    EXPECT_TRUE(j["scenario"]["world"].contains("model")) << name;
  }
  const Json radar = json({"run", scenario_file("tracking_radar"), "--runs", "64", "--format", "json"});
  EXPECT_FALSE(radar.contains("exact"));
  EXPECT_EQ(radar["rmse"]["position_m"].size(), 100U);
  EXPECT_TRUE(radar["rmse"]["heading_rad"].empty());
  // What no filter is below, by step and on average.
  EXPECT_EQ(radar["bound"]["runs"], 64);
  const Json& position = radar["bound"]["blocks"][0];
  EXPECT_EQ(position["of"], "position");
  EXPECT_EQ(position["bound"].size(), 100U);
  EXPECT_LE(position["bound"][99].get<double>(), position["at_truth"][99].get<double>());
  const Json& accuracy = radar["battery"]["accuracy"][0];
  EXPECT_LT(accuracy["bound"].get<double>(), accuracy["rmse"]["upper"].get<double>());
  EXPECT_LT(accuracy["efficiency"]["lower"].get<double>(), 1.0);
  const Json late = json({"run", scenario_file("tracking_radar"), "--runs", "16", "--set",
                          "noise.measurement_delay=1", "--format", "json"});
  EXPECT_TRUE(late["bound"].contains("reason"));
  EXPECT_FALSE(late["battery"]["accuracy"][0].contains("bound"));
}

TEST_F(RunCommand, MissedMeasurementsGiveEveryRunItsOwnCovariance) {
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

TEST_F(RunCommand, ASingleRunIsReplayedAlone) {
  write("a.toml", kMonobot);
  const Finished f = run({"run", "a.toml", "--only-run", "17", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["run"], 17);
  EXPECT_EQ(j["steps"].size(), 31U);
  EXPECT_EQ(j["steps"][30]["covariance"].size(), 3U);
  EXPECT_EQ(run({"run", "a.toml", "--only-run", "17"}).code, 0);
  EXPECT_EQ(run({"run", "a.toml", "--only-run", "-1"}).code, 2);
  EXPECT_EQ(run({"run", "a.toml", "--runs", "128", "--only-run", "127"}).code, 0);
  EXPECT_EQ(refusal({"run", "a.toml", "--runs", "128", "--only-run", "128"}),
            "credence: --only-run 128: the runs of this study are 0 to 127\n");
}

TEST_F(RunCommand, NothingIsSweptByIt) {
  write("a.toml", kMonobot);
  EXPECT_EQ(
      refusal({"run", "a.toml", "--set", "sweep.x=1"}),
      "credence: --set sweep.x=1: of one configuration nothing is swept; credence sweep runs them all\n");
}

TEST_F(RunCommand, FailedRunsAreNamedAndExitWith3) {
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

TEST_F(RunCommand, ReportsAreCompleteAndFiguresAreThere) {
  write("a.toml", kMonobot);
  const Finished f = run({"run", "a.toml", "--out", "out"});
  ASSERT_EQ(f.code, 0) << f.err;
  const std::string page = read("out/index.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "a.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "a-run.pdf"));
}

TEST_F(RunCommand, ReportsShowNothingOfLandmarks) {
  for (const char* name : {"linear", "tracking", "tracking_radar"}) {
    ASSERT_EQ(
        run({"run", scenario_file(name), "--runs", "64", "--set", "study.steps=20", "--out", name}).code, 0);
    const std::string page = read(std::filesystem::path(name) / "index.html");
    EXPECT_THAT(page, HasSubstr(std::string(name) == "linear" ? "load" : "velocity.y"));
    for (const char* word : {"landmark", "Vehicle", "heading"})
      EXPECT_THAT(page, Not(HasSubstr(word))) << name;
  }
}

// H = 0 and R = 0: S is never positive definite.
TEST_F(RunCommand, AReportOfRunsThatAllFailedSaysSo) {
  const Finished f = run({"run", scenario_file("linear"), "--runs", "64", "--set", "world.H=[[0, 0, 0]]",
                          "--set", "world.R=[[0]]", "--out", "failed"});
  EXPECT_EQ(f.code, 3) << f.err;
  EXPECT_THAT(read("failed/index.html"), HasSubstr("64 of 64 runs failed"));
}

TEST_F(RunCommand, RunSaysThatItLeavesASweepAside) {
  std::vector<std::string> command = {"run", "mistuned_sweep", "--runs", "64"};
  for (const bool quiet : {false, true}) {
    if (quiet) command.emplace_back("--quiet");
    const Finished f = run(command);
    EXPECT_EQ(f.code, 0);
    EXPECT_EQ(
        f.err,
        "mistuned_sweep has a [sweep], which run leaves aside; all of its configurations: credence sweep "
        "mistuned_sweep\n")
        << quiet;
  }
}

TEST_F(RunCommand, CtrlCSavesReportsWhatIsThereAndExits130) {
  write("a.toml", kMonobot);
  const pid_t child =
      start({"run", "a.toml", "--runs", "100000000", "--out", "out", "--threads", "1", "--format", "json"});
  wait_for_chunks("out");
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["complete"], false);
  EXPECT_GT(j["runs"], 0);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "results.sqlite"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "index.html"));
  // The answer is that of the runs that are stored, whenever it is asked for.
  const Json stored = json({"show", "out", "--format", "json"});
  EXPECT_EQ(stored["runs"], j["runs"]);
  EXPECT_EQ(stored["word"], j["word"]);
  EXPECT_EQ(stored["battery"], j["battery"]);
}

TEST_F(RunCommand, FreshLeavesTheStoreOfAProcessThatWrites) {
  write("a.toml", kMonobot);
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
  write("a.toml", kMonobot);
  const pid_t child = start({"run", "a.toml", "--runs", "100000000", "--out", "out", "--threads", "1"});
  wait_for_chunks("out");
  fs::rename(folder_ / "out", folder_ / "moved");
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("out/results.sqlite: was moved or removed"), std::string::npos) << f.err;
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "no page without results";
}

TEST_F(RunCommand, AnOutputThatCannotBeWrittenIsAnErrorThatNamesIt) {
  write("a.toml", kMonobot);
  write("file", "not a folder");
  const Finished f = run({"run", "a.toml", "--out", "file/out"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("file/out"), std::string::npos) << f.err;
  EXPECT_EQ(read("file"), "not a folder");
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

TEST_F(RunCommand, WhatNeedsMoreMemoryThanThereIsIsRefusedByKey) {
  write("a.toml", kMonobot);
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
  write("a.toml", kMonobot + "[noise]\nmeasurement_variance = 0\n");
  const Finished f = run({"run", "a.toml", "--format", "json"});
  EXPECT_TRUE(f.code == 0 || f.code == 3) << f.code << f.err;
  EXPECT_TRUE(Json::accept(f.out));
}

TEST_F(RunCommand, ScenariosOfOneNameAreRefusedBeforeTheyAreRun) {
  fs::create_directories(folder_ / "b");
  write("a.toml", kMonobot);
  write("b/a.toml", kMonobot);
  write("...toml", kMonobot);
  const Finished same = run({"run", "a.toml", "b/a.toml", "--out", "out"});
  EXPECT_EQ(same.code, 2);
  EXPECT_NE(same.err.find("b/a.toml: another scenario is called a"), std::string::npos) << same.err;
  EXPECT_EQ(run({"run", "a.toml", "...toml", "--out", "out"}).code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  EXPECT_FALSE(fs::exists(folder_ / "results.sqlite"));
}

TEST_F(RunCommand, ADiffusePriorWithMissedMeasurementsIsReported) {
  write("a.toml", kMonobot +
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

/// What is wrong, the scenario text, and words that the one message must contain.
struct Bad {
  const char* what;
  std::string text;
  std::vector<std::string> words;
};

TEST_F(RunCommand, EveryMalformedScenarioEndsWith2AndOneMessage) {
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

}  // namespace
}  // namespace credence::internal
