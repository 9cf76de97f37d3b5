// `credence run --log` and `credence check` as a user types them: the built binary, its documents, its exit
// codes.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class CheckCommand : public CommandTest {};

TEST_F(CheckCommand, AFileThatIsNamedTwiceIsRefused) {
  fs::create_directories(folder_ / "logs");
  write("logs/a.csv", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n");
  for (const auto& twice : {std::vector<std::string>{"logs/a.csv", "logs/../logs/a.csv"},
                            std::vector<std::string>{"logs", "logs/a.csv"}}) {
    const Finished f = run({"check", "--pool", twice[0], twice[1]});
    EXPECT_EQ(f.code, 2);
    EXPECT_NE(f.err.find("a.csv: is named twice"), std::string::npos) << f.err;
  }
}

TEST_F(CheckCommand, AnInterruptionIsHeardWithinAFile) {
  std::string text = "innovation.1,S.1.1\n";
  for (int i = 0; i < 3'000'000; ++i) text += "0.5,1\n";
  write("a.csv", text);
  const pid_t child = start({"check", "a.csv"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_TRUE(f.err.find("interrupted before the first rows") != std::string::npos ||
              f.out.find("interrupted: its first ") != std::string::npos)
      << f.err << f.out;
}

// 150 runs: three chunks.
const std::string kPlane = "[world]\nmodel = \"planar\"\nlandmarks = 3\n[study]\nruns = 150\nsteps = 15\n";

TEST_F(CheckCommand, GivesTheNumbersOfTheRunThatWroteTheLogsToTheLastDigit) {
  write("line.toml", kLine);
  write("plane.toml", kPlane);
  for (const std::string world : {"line", "plane"}) {
    const Json run = json({"run", world + ".toml", "--log", world, "--format", "json", "--quiet"});
    const Json plain = json({"run", world + ".toml", "--format", "json", "--quiet"});
    const Json check = json({"check", world, "--format", "json", "--quiet"});
    EXPECT_EQ(check["files"], 150);
    EXPECT_EQ(check["rejected_rows"], 0);
    EXPECT_EQ(check["rows"], 150 * run["steps"].get<int>());
    for (const char* key : {"nees", "nis", "runs", "steps", "state_dim", "verdict"}) {
      EXPECT_EQ(check[key], run[key]) << world << ' ' << key;
    }
    for (const char* key : {"trace", "vehicle"}) {
      EXPECT_EQ(check["covariance"][key], run["covariance"][key]) << world << ' ' << key;
    }
    for (std::size_t k = 0; k < run["steps"].get<std::size_t>(); ++k) {
      const double a = check["covariance"]["landmarks"][k], b = run["covariance"]["landmarks"][k];
      EXPECT_NEAR(a, b, 1e-13 * b) << world << ' ' << k;  // summed in another order
    }
    if (world == "plane") {
      EXPECT_EQ(check["vehicle_nees"], run["vehicle_nees"]);
      for (const char* key : {"position_m", "heading_rad", "landmark_m"}) {
        for (std::size_t k = 0; k < 15; ++k) {
          const double a = check["rmse"][key][k], b = run["rmse"][key][k];
          EXPECT_NEAR(a, b, 1e-14 * b) << key << ' ' << k;  // summed in another order
        }
      }
    }
    for (const char* key : {"nees", "nis"}) {
      const double a = run[key]["mean"], b = plain[key]["mean"];
      EXPECT_NEAR(a, b, 1e-12 * b) << world << ' ' << key;  // kernels in lanes round differently
    }
  }
}

// Five of the ten landmarks are seen from the start, and not the first five: a study and its logs have the
// same evidence, block by block and test by test.
TEST_F(CheckCommand, HasTheTestsOfTheRunWhereLandmarksComeLate) {
  write("loop.toml",
        "[world]\nmodel = \"planar\"\nlandmarks = 10\npath = \"circle\"\npath_radius = 10.0\nsensor_range = "
        "12.0\n[study]\nruns = 70\nsteps = 60\n");
  const Json run = json({"run", "loop.toml", "--log", "loop", "--format", "json", "--quiet"});
  const Json check = json({"check", "loop", "--format", "json", "--quiet"});
  const auto p_values = [](const Json& document) {
    std::map<std::string, double> tests;
    for (const Json& test : document["battery"]["tests"]) {
      std::string name = test["name"];
      if (const auto at = name.find("vehicle"); at != std::string::npos) name.replace(at, 7, "pose");
      std::erase(name, ' ');
      if (test["p_value"].is_number()) tests[name] = test["p_value"];
    }
    return tests;
  };
  const auto expected = p_values(run), found = p_values(check);
  EXPECT_GT(expected.count("NEESoflandmark9"), 0U);
  EXPECT_GT(expected.count("whitenessoftheinnovation"), 0U);
  for (const auto& [name, p] : expected) {
    ASSERT_GT(found.count(name), 0U) << name;
    EXPECT_NEAR(found.at(name), p, 1e-9) << name;
  }
  EXPECT_EQ(found.size(), expected.size());
}

// The stretches of few long runs tell the factor on the whole P; that of single states is of whole runs.
TEST_F(CheckCommand, AFactorHasOneIntervalEverywhere) {
  std::mt19937_64 bits(7);
  std::normal_distribution<double> normal;
  for (const int runs : {1, 3, 5}) {
    std::string text = "run,step,error.x,error.y,P.1.1,P.1.2,P.2.2\n";
    for (int run = 0; run < runs; ++run) {
      double x = 0.0, y = 0.0;
      for (int step = 0; step < 2000; ++step) {
        x = 0.5 * x + normal(bits);
        y = 0.5 * y + normal(bits);
        text += fmt::format("{},{},{:.9g},{:.9g},1,0,1\n", run, step, x, y);
      }
    }
    write("few.csv", text);
    const Json check = json({"check", "few.csv", "--format", "json", "--quiet"});
    const Json& factor = check["nees"]["factor"];
    // The variance is 1/(1 - 0.25); of 2000 steps and more the standard error is below 0.05.
    EXPECT_NEAR(factor["value"], 4.0 / 3.0, 0.25) << runs;
    EXPECT_LT(factor["upper"].get<double>() - factor["lower"].get<double>(), 0.5) << runs;
    for (const char* end : {"value", "lower", "upper"})
      EXPECT_EQ(check["calibration"]["factor"][end], factor[end]) << runs << ' ' << end;
    EXPECT_EQ(check["battery"]["scale"]["covariance"]["upper"], factor["upper"]) << runs;
  }
}

TEST_F(CheckCommand, NamesTheStatesWithoutATruthAndRefusesMoreSensorsThanItCanJudge) {
  write("part.csv",
        "step,estimate.x,estimate.b,truth.x,truth.b,P.1.1,P.1.2,P.2.2\n0,1,2,1.5,,1,0,1\n1,1,2,0.5,,1,0,1\n");
  EXPECT_NE(
      run({"check", "part.csv", "--quiet"}).out.find("No row has an estimate and a truth of b, which is"),
      std::string::npos);
  const auto sensors = [&](int count) {
    std::string names = "step", row = "0";
    for (int i = 0; i < count; ++i) {
      names += fmt::format(",nis.s{}.1", i);
      row += ",1";
    }
    write("wide.csv", names + '\n' + row + '\n');
    return run({"check", "wide.csv", "--quiet"});
  };
  const Finished refused = sensors(1001);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("wide.csv: has 1001 sensors, of innovations or of NIS; at most 1000"),
            std::string::npos)
      << refused.err;
  EXPECT_NE(sensors(65).out.find("is not tested: 65 sensors are more than 64."), std::string::npos);
  EXPECT_EQ(sensors(64).out.find("is not tested: 64"), std::string::npos);
}

// What a log says of the filter: R, that it linearises, that it inflates.
TEST_F(CheckCommand, HasTheCausesOfTheRun) {
  const std::string more = "landmarks = 3\n[study]\nruns = 60\nsteps = 80\n";
  write("scale.toml", "[world]\nmodel = \"monobot\"\n" + more + "[filter]\nmeasurement_scale = 0.5\n");
  write("inflated.toml", "[world]\nmodel = \"monobot\"\n" + more + "[filter]\ninflation = \"map\"\n");
  write("plane.toml", "[world]\nmodel = \"planar\"\n" + more + "[filter]\nmeasurement_scale = 0.5\n");
  for (const std::string world : {"scale", "inflated", "plane"}) {
    for (const std::string format : {"csv", "npz"}) {
      const std::string folder = world + format;
      const Json run = json({"run", world + ".toml", "--log", folder, "--log-format", format, "--format",
                             "json", "--quiet"})["battery"];
      const Json check = json({"check", folder, "--format", "json", "--quiet"})["battery"];
      ASSERT_FALSE(run["causes"].empty()) << world;
      ASSERT_EQ(check["causes"].size(), run["causes"].size()) << folder;
      for (std::size_t i = 0; i < run["causes"].size(); ++i) {
        EXPECT_EQ(check["causes"][i]["cause"], run["causes"][i]["cause"]) << folder;
      }
      const Json &of_run = run["scale"]["measurement_noise"], &of_check = check["scale"]["measurement_noise"];
      ASSERT_EQ(of_check["factor"].is_number(), of_run["factor"].is_number()) << folder;
      if (world == "inflated") continue;  // to first order no R mends it
      EXPECT_NEAR(of_check["factor"].get<double>(), of_run["factor"].get<double>(), 1e-9) << folder;
    }
  }
}

TEST_F(CheckCommand, ArraysGiveTheNumbersOfTheRunToTheLastDigit) {
  write("line.toml", kLine);
  write("plane.toml", kPlane);
  for (const std::string world : {"line", "plane"}) {
    const Json run =
        json({"run", world + ".toml", "--log", world, "--log-format", "npz", "--format", "json", "--quiet"});
    const Json check = json({"check", world, "--format", "json", "--quiet"});
    EXPECT_EQ(check["files"], 150);
    EXPECT_EQ(check["rows"], 150 * run["steps"].get<int>());
    for (const char* key : {"nees", "nis", "runs", "steps", "state_dim"}) {
      EXPECT_EQ(check[key], run[key]) << world << ' ' << key;
    }
  }
}

TEST_F(CheckCommand, BagsGiveTheNumbersOfThePoseOfTheRun) {
  write("plane.toml", kPlane);
  for (const std::string scale : {"1", "0.3"}) {
    const Json run = json({"run", "plane.toml", "--set", "filter.process_scale=" + scale, "--log", "logs",
                           "--fresh", "--log-format", "mcap", "--format", "json", "--quiet"});
    const Json check = json(
        {"check", "logs", "--truth-topic", "/truth", "--chart", "planar", "--format", "json", "--quiet"});
    EXPECT_EQ(check["files"], 150);
    EXPECT_EQ(check["rows"], 150 * 15);
    EXPECT_EQ(check["poses"][0]["chart"], "planar");
    const Json &pose = run["vehicle_nees"], &seen = check["vehicle_nees"];
    EXPECT_EQ(seen["verdict"], pose["verdict"]);
    EXPECT_EQ(seen["expected"], pose["expected"]);
    const double mean = pose["mean"];
    EXPECT_NEAR(seen["mean"].get<double>(), mean, 1e-12 * mean);
    // Rows of z, roll and pitch are zero: the chart of the standard judges the same three.
    const Json standard = json({"check", "logs", "--truth-topic", "/truth", "--format", "json", "--quiet"});
    EXPECT_NEAR(standard["nees"]["mean"].get<double>(), mean, 1e-12 * mean);
  }
  write("line.toml", kLine);
  const Finished refused = run({"run", "line.toml", "--log", "line", "--log-format", "mcap", "--quiet"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("no pose in the plane"), std::string::npos) << refused.err;
}

TEST_F(CheckCommand, SameBitsForAnyNumberOfThreadsAndHoweverRunsLieInFiles) {
  write("a.toml", kLine);
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs", "--quiet"}).code, 0);
  Json one = json({"check", "logs", "--format", "json", "--quiet", "--threads", "1"});
  for (const char* threads : {"2", "5"}) {
    EXPECT_EQ(json({"check", "logs", "--format", "json", "--quiet", "--threads", threads}), one) << threads;
  }
  // All runs in one file with a run column.
  std::string all;
  for (int r = 0; r < 150; ++r) {
    char name[32];
    std::snprintf(name, sizeof name, "logs/run-%06d.csv", r);
    std::istringstream lines(read(name));
    std::string line;
    std::getline(lines, line);
    if (r == 0) all = "run," + line + "\n";
    while (std::getline(lines, line)) all += std::to_string(r) + "," + line + "\n";
  }
  write("all.csv", all);
  Json joined = json({"check", "all.csv", "--format", "json", "--quiet"});
  EXPECT_EQ(joined["files"], 1);
  joined["files"] = one["files"];
  EXPECT_EQ(joined["calibration"]["unit_names"][1], "run 1 of all");
  joined["calibration"]["unit_names"] = one["calibration"]["unit_names"];
  EXPECT_EQ(joined, one);
}

TEST_F(CheckCommand, FindsAMistunedFilterFromItsLogs) {
  write("a.toml", kLine);
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs", "--quiet", "--set", "filter.inflation=none", "--set",
                 "filter.measurement_scale=0.4"})
                .code,
            0);
  const Json j = json({"check", "logs", "--format", "json", "--quiet", "--fail-on-inconsistent"}, 1);
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_EQ(j["nees"]["verdict"], "optimistic");
}

TEST_F(CheckCommand, AnUndecidedFilterIsNotAccused) {
  write("short.csv", "estimate.x,truth.x,P.1.1\n0.5,0,1\n-1,0,1\n0.2,0,1\n");
  const Json j = json({"check", "short.csv", "--format", "json", "--quiet", "--fail-on-inconsistent"}, 0);
  EXPECT_EQ(j["verdict"], "undecided");
}

// No verdict could fail on it; of rows that are rejected, or have no truth, the report says why.
TEST_F(CheckCommand, ALogOfWhichNothingIsANumberIsNoData) {
  write("nan.csv", "estimate.x,truth.x,P.1.1,innovation.1,S.1.1\nnan,0,1,,\nnan,0,1,,\n");
  const Finished f = run({"check", "nan.csv", "--fail-on-inconsistent"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("nan.csv: there is nothing to judge in 2 rows"), std::string::npos) << f.err;
  write("one.csv", "estimate.x,truth.x,P.1.1,innovation.1,S.1.1\nnan,0,1,,\nnan,0,1,0.5,1\n");
  EXPECT_EQ(run({"check", "one.csv"}).code, 0);
}

TEST_F(CheckCommand, SaysWhatItReadRejectedAndWhere) {
  write("log.csv", "estimate.x,truth.x,P.1.1\n1,0,1\n1,0,-1\n0.5,0,1\n0.1,0,0\n");
  const Finished f = run({"check", "log.csv", "--sensitivity"});
  EXPECT_EQ(f.code, 3) << f.err;
  EXPECT_NE(f.out.find("REJECTED: 1 row, the covariance has a negative variance (first: log.csv:3)"),
            std::string::npos)
      << f.out;
  EXPECT_NE(f.out.find("log.csv:5"), std::string::npos) << f.out;
  EXPECT_NE(f.err.find("rows/s"), std::string::npos) << f.err;
  const Json j = json({"check", "log.csv", "--format", "json", "--quiet", "--sensitivity"}, 3);
  EXPECT_EQ(j["rejected_rows"], 1);
  EXPECT_THAT(j["wrongly_certain"].dump(), testing::HasSubstr("log.csv:5"));
  EXPECT_EQ(j["rows"], 4);
  EXPECT_TRUE(j["sensitivity"].is_object());
}

TEST_F(CheckCommand, WhereNothingIsClaimedButCertaintyTheAnswerSaysSo) {
  write("log.csv", "estimate.x,truth.x,P.1.1\n1,0,0\n1,0,0\n0.5,0,0\n");
  const Finished f = run({"check", "log.csv"});
  EXPECT_EQ(f.code, 3) << f.err;
  EXPECT_THAT(f.out,
              testing::StartsWith("Can this covariance be trusted? Undecided: x errs in 3 of 3 rows where P "
                                  "claims certainty (variance 0)\n"));
}

/// A trajectory of 40 poses on a line, with unit covariance in position and orientation.
std::string poses(double shift, bool with_covariance) {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += std::to_string(i) + " " + std::to_string(i + shift * (i % 2 == 0 ? 1 : -1)) + " 0 0 0 0 0 1";
    if (with_covariance) text += " 1 0 0 1 0 1 1 0 0 1 0 1";
    text += "\n";
  }
  return text;
}

TEST_F(CheckCommand, AFormatIsSeenFromTheFileOrNamed) {
  write("estimate.txt", poses(0.5, true));
  write("truth.txt", poses(0.0, false));
  const Json seen = json({"check", "estimate.txt", "--truth", "truth.txt", "--format", "json", "--quiet"});
  const Json named = json({"check", "estimate.txt", "--input", "openvins", "--truth", "truth.txt", "--format",
                           "json", "--quiet"});
  EXPECT_EQ(seen, named);
  EXPECT_EQ(seen["rows"], 40);
  EXPECT_TRUE(seen["format"].get<std::string>().starts_with("OpenVINS trajectory")) << seen["format"];
}

TEST_F(CheckCommand, SaysWhenItIsWrongInSecondsWhereTheLogDoes) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 40, kSteps = 20, kWrongFrom = 11;
  const auto log = [&](double clock_of_a_run_s) {
    std::string text = "run,time,error.x,P.1.1\n";
    for (int r = 0; r < kRuns; ++r) {
      for (int k = 1; k <= kSteps; ++k) {
        text += std::to_string(r) + "," + std::to_string(clock_of_a_run_s * r + 0.1 * k) + "," +
                std::to_string((k < kWrongFrom ? 1.0 : 5.0) * normal(random)) + ",1\n";
      }
    }
    return text;
  };
  write("one_clock.csv", log(0.0));
  write("clocks.csv", log(100.0));
  const Json same = json({"check", "one_clock.csv", "--format", "json", "--quiet", "--out", "page"});
  const std::string says = same["word"]["says"];
  EXPECT_NE(says.find("from step 11 on (t = 1.1 s)"), std::string::npos) << says;
  EXPECT_NEAR(same["nees"]["optimistic_steps"]["first_time_s"].get<double>(), 1.1, 1e-9);
  EXPECT_NE(read("page/one_clock.csv").find("step,time,nees_mean"), std::string::npos);
  EXPECT_NE(read("page/index.html").find("time (s)"), std::string::npos);
  const std::string others = json({"check", "clocks.csv", "--format", "json", "--quiet"})["word"]["says"];
  EXPECT_NE(others.find("from step 11 on (1.0 s after the start)"), std::string::npos) << others;
}

TEST_F(CheckCommand, PosesOfACsvAreSeen) {
  std::string header = "timestamp,x,y,z,qx,qy,qz,qw", estimate, truth = "timestamp,x,y,z,qx,qy,qz,qw\n";
  for (int i = 0; i < 36; ++i) header += ",cov_" + std::to_string(i);
  for (int k = 0; k < 40; ++k) {
    estimate += std::to_string(0.1 * k) + "," + std::to_string(k % 2 == 0 ? 0.1 : -0.1) + ",0,0,0,0,0,1";
    for (int i = 0; i < 36; ++i) estimate += i % 7 == 0 ? ",0.01" : ",0";
    estimate += "\n";
    truth += std::to_string(0.1 * k) + ",0,0,0,0,0,0,1\n";
  }
  write("e.csv", header + "\n" + estimate);
  write("t.csv", truth);
  const Json j = json({"check", "e.csv", "--truth", "t.csv", "--format", "json", "--quiet"});
  EXPECT_EQ(j["rows"], 40);
  EXPECT_NEAR(j["nees"]["mean"].get<double>(), 1.0, 1e-9);
  EXPECT_TRUE(j["format"].get<std::string>().starts_with("CSV of poses")) << j["format"];
  write("bare.csv", estimate);
  const Json bare = json({"check", "bare.csv", "--truth", "t.csv", "--format", "json", "--quiet"});
  EXPECT_EQ(bare["nees"], j["nees"]);
  const Finished refused = run({"check", "t.csv", "--input", "poses", "--truth", "t.csv"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("t.csv:1: names no poses with a covariance"), std::string::npos) << refused.err;
}

TEST_F(CheckCommand, ListsWhatIsInALogWithoutJudgingIt) {
  write("a.csv", "time,estimate.x,truth.x,P.1.1,innovation.gps.1,S.gps.1.1\n1,1,0,1,,\n2,1,0,1,0.5,1\n");
  const Finished f = run({"check", "--list", "a.csv"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("innovation gps"), std::string::npos) << f.out;
  EXPECT_EQ(f.out.find("consistent"), std::string::npos) << f.out;
  const Json log = json({"check", "--list", "a.csv", "--format", "json"})["logs"][0];
  EXPECT_EQ(log["topics"][0]["messages"], 2);
  EXPECT_EQ(log["topics"][1]["messages"], 1);
  EXPECT_EQ(log["topics"][1]["use"], "innovations");
  EXPECT_NE(f.out.find("\n1 run."), std::string::npos) << f.out;
}

TEST_F(CheckCommand, ListsATrajectoryWithoutACovarianceAsATruth) {
  write("truth.tum", "0 1 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n");
  const Finished f = run({"check", "--list", "truth.tum"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("It is no log, but a truth, which is to be named by --truth."), std::string::npos)
      << f.out;
  const Json topic = json({"check", "--list", "truth.tum", "--format", "json"})["logs"][0]["topics"][0];
  EXPECT_EQ(topic["use"], "truth");
  EXPECT_EQ(topic["covariance"], false);
  EXPECT_EQ(topic["messages"], 2);
  write("broken.tum", "0 1 0 0 0 0 0 1\n0.5 1 0 0 0 0 0\n");
  EXPECT_EQ(run({"check", "--list", "broken.tum"}).code, 2);
}

TEST_F(CheckCommand, OfACutFileThePartBeforeIsJudgedIfAsked) {
  write("cut.csv", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n0.25");
  EXPECT_EQ(run({"check", "cut.csv"}).code, 2);
  const Json j = json({"check", "cut.csv", "--partial", "--format", "json", "--quiet"});
  EXPECT_EQ(j["rows"], 2);
  ASSERT_EQ(j["remarks"].size(), 1U);
  EXPECT_NE(j["remarks"][0].get<std::string>().find("only a part could be read: cut.csv:4"),
            std::string::npos);
  write("cut.csv", "innovation.1,S.1.1\n0.5");
  EXPECT_EQ(run({"check", "cut.csv", "--partial"}).code, 2);  // nothing before it
}

TEST_F(CheckCommand, InnovationsAloneSayWhatTheyCannotTell) {
  write("a.csv", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n");
  const Finished f = run({"check", "a.csv", "--quiet"});
  EXPECT_NE(f.out.find("cannot be known from them"), std::string::npos) << f.out;
}

TEST_F(CheckCommand, StandardInputIsALogToo) {
  write("a.toml", "[world]\nmodel = \"monobot\"\n[study]\nruns = 1\nsteps = 50\n");
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs"}).code, 0);
  const Json file = json({"check", "logs/run-000000.csv", "--format", "json", "--quiet"});
  const std::string command = "cd " + folder_.path().string() + " && TMPDIR=. " + credence_binary().string() +
                              " check - --format json --quiet < logs/run-000000.csv > piped";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(Json::parse(read("piped")), file);
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    EXPECT_NE(entry.path().filename().string().substr(0, 9), "credence-") << "what was kept is removed";
  }
}

TEST_F(CheckCommand, BadInputIsOneErrorWithFileAndLine) {
  write("good.csv", "estimate.x,truth.x,P.1.1\n1,0,1\n");
  write("bad.csv", "estimate.x,truth.x,P.1.1\n1,0,1\n1,zero,1\n");
  write("pose.txt", "1 0 0 0 0 0 0 1\n");
  fs::create_directory(folder_ / "empty");
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"check", "good.csv", "bad.csv"}, "--pool"},
      {{"check", "--pool", "good.csv", "bad.csv"},
       "bad.csv:3: column truth.x: 'zero' is not a finite number"},
      {{"check", "absent.csv"}, "absent.csv: there is no such file"},
      {{"check", "empty"}, "the folder holds no logs: no file with one of .mcap"},
      {{"check", "pose.txt", "--input", "openvins"}, "name the truth by --truth"},
      {{"check", "pose.txt", "--input", "openvins", "--truth", "pose.txt"}, "pose.txt:1: 8 fields where 20"},
      {{"check", "good.csv", "--truth", "pose.txt"},
       "good.csv is read as Credence CSV, which holds its truth"},
      {{"check", "--list", "good.csv", "--truth", "pose.txt"},
       "good.csv is read as Credence CSV, which holds its truth"},
      {{"check", "pose.txt"}, "pose.txt: a trajectory (tum) has no truth in it: name the truth by --truth"},
      {{"check", "pose.txt", "--truth", "pose.txt"}, "poses without a covariance"},
      {{"check", "pose.txt", "--input", "excel"}, "--input"},
      {{"check", "good.csv", "--confidence", "2"}, "--confidence"}};
  for (const auto& [arguments, expected] : cases) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2);
    EXPECT_NE(f.err.find(expected), std::string::npos) << f.err;
    EXPECT_EQ(f.out, "");
  }
  EXPECT_EQ(run({"check", "--help"}).code, 0);
}

TEST_F(CheckCommand, JudgesATrajectoryAgainstItsTruth) {
  std::string estimate = "# timestamp(s) tx ty tz qx qy qz qw Pr11 …\n",
              truth = "#timestamp [ns], p_RS_R_x [m]\n";
  for (int i = 0; i < 50; ++i) {
    const std::string t = std::to_string(100 + 0.05 * i);
    estimate += t + " " + std::to_string(0.1 * i + (i % 3 - 1) * 0.1) + " 0 0 0 0 0 1 1e-4 0 0 1e-4 0 1e-4 " +
                "0.01 0 0 0.01 0 0.01\n";
    truth += std::to_string(100'000'000'000LL + 50'000'000LL * i) + "," + std::to_string(0.1 * i) +
             ",0,0,1,0,0,0\n";
  }
  write("e.txt", estimate);
  write("t.csv", truth);
  const Json j =
      json({"check", "e.txt", "--input", "openvins", "--truth", "t.csv", "--format", "json", "--quiet"});
  EXPECT_EQ(j["rows"], 50);
  EXPECT_EQ(j["runs"], 1);
  EXPECT_EQ(j["unmatched_rows"], 0);
  EXPECT_EQ(j["nees"]["expected"], 6.0);
  EXPECT_NEAR(j["blocks"]["position"]["mean"].get<double>(), 33.0 / 50.0, 1e-6);
  EXPECT_EQ(j["blocks"]["orientation"]["mean"], 0.0);
  EXPECT_TRUE(j["single_run"].is_object());
  EXPECT_NE(j["format"].get<std::string>().find("interpolated"), std::string::npos);
}

TEST_F(CheckCommand, ATrajectoryIsShiftedInTimeAndAlongALeverArm) {
  std::string estimate, truth;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.05 * i, s = 0.7 * (t + 0.1),
                 noise = 0.02 * std::sin(37.0 * i) + 0.02 * std::cos(91.7 * i);
    const auto row = [](double at, double x, double y) {
      return std::to_string(at) + " " + std::to_string(x) + " " + std::to_string(y) + " 0.5 0 0 0 1";
    };
    // 0.1 s early, and at the height of the truth.
    estimate += row(t, 4.0 * std::cos(s) + noise, 3.0 * std::sin(s) - noise);
    for (int k = 0; k < 6; ++k) {
      for (int j = k; j < 6; ++j) estimate += k == j ? " 1e-3" : " 0";
    }
    estimate += "\n";
    truth += row(t, 4.0 * std::cos(0.7 * t), 3.0 * std::sin(0.7 * t)) + "\n";
  }
  write("e.tum", estimate);
  write("t.txt", truth);
  const std::vector<std::string> given = {
      "check", "e.tum", "--truth", "t.txt", "--format", "json", "--quiet", "--max-time-difference", "0.06"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = given;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const Json plain = json(with({}));
  EXPECT_TRUE(plain["poses"][0]["time_offset"].is_null());
  EXPECT_EQ(plain["poses"][0]["charts"].size(), 9U);
  const Json found = json(with({"--time-offset", "estimate"}));
  const Json& offset = found["poses"][0]["time_offset"];
  EXPECT_TRUE(offset["used"]) << offset;
  EXPECT_LT(offset["lower"].get<double>(), 0.1);
  EXPECT_GT(offset["upper"].get<double>(), 0.1);
  EXPECT_LT(found["nees"]["mean"], 0.5 * plain["nees"]["mean"].get<double>());
  const Json moved = json(with({"--time-offset", "0.1", "--lever-arm", "0,0,0"}));
  EXPECT_NEAR(moved["nees"]["mean"].get<double>(), found["nees"]["mean"].get<double>(), 0.5);
  const Json lifted = json(with({"--time-offset", "0.1", "--lever-arm", "0,0,-0.5"}));
  EXPECT_NEAR(lifted["nees"]["mean"].get<double>(), moved["nees"]["mean"].get<double>() + 0.25e3, 0.5);
  for (const auto& [option, value] :
       {std::pair{"--time-offset", "soon"}, std::pair{"--lever-arm", "1,2"},
        std::pair{"--lever-arm", "1e400,0,0"}, std::pair{"--lever-arm", "1,2,3,"}}) {
    const Finished refused = run(with({option, value}));
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find(std::string(option) + (option[2] == 't' ? " soon" : ": accepted")),
              std::string::npos)
        << refused.err;
  }
  write("log.csv", "innovation.1,S.1.1\n1,1\n");
  for (const char* seconds : {"1", "0"}) {
    const Finished refused = run({"check", "log.csv", "--time-offset", seconds});
    EXPECT_EQ(refused.code, 2) << seconds;
    EXPECT_NE(refused.err.find("accepted are bags and trajectories"), std::string::npos) << refused.err;
  }
}

TEST_F(CheckCommand, AnOptionThatWouldDoNothingIsRefused) {
  write("a.csv", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n");
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--topic", "/x"},
                                                 {"--truth-topic", "/x"},
                                                 {"--instance", "1"},
                                                 {"--chart", "gtsam"},
                                                 {"--orientation-error", "rpy"},
                                                 {"--align", "yaw"},
                                                 {"--truth-time", "nearest"},
                                                 {"--max-time-difference", "1"}}) {
    const std::string said = refusal({"check", "a.csv", option[0], option[1]});
    EXPECT_NE(said.find(option[0]), std::string::npos) << said;
    EXPECT_NE(said.find("a.csv is read as Credence CSV; accepted are "), std::string::npos) << said;
  }
  for (const char* option : {"--junit", "--markdown", "--out"}) {
    EXPECT_NE(refusal({"check", "a.csv", "--list", option, "out"}).find(option), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }
  write("p.toml", kPlane);
  ASSERT_EQ(run({"run", "p.toml", "--runs", "1", "--log", "bags", "--log-format", "mcap", "--quiet"}).code,
            0);
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--align", "yaw"}, {"--chart", "planar"}, {"--time-offset", "0.1"}}) {
    const std::string said = refusal({"check", "bags", option[0], option[1]});
    EXPECT_NE(said.find(option[0]), std::string::npos) << said;
    EXPECT_NE(said.find("does nothing without a truth"), std::string::npos) << said;
  }
}

TEST_F(CheckCommand, NothingIsWrittenOverWhatIsReadOrWrittenBesides) {
  const std::string log = "innovation.1,S.1.1\n0.5,1\n-0.5,1\n";
  write("a.csv", log);
  write("b.json", run({"check", "a.csv", "--format", "json", "--quiet"}).out);
  fs::create_directories(folder_ / "folder");
  fs::create_symlink("a.csv", folder_ / "link.csv");
  EXPECT_EQ(refusal({"check", "a.csv", "--junit", "x", "--markdown", "./x"}),
            "credence: --markdown ./x: is the file of --junit; name another file\n");
  EXPECT_EQ(refusal({"check", "a.csv", "--junit", "link.csv"}),
            "credence: --junit link.csv: is a log that is judged; name another file\n");
  EXPECT_EQ(refusal({"check", "a.csv", "--baseline", "b.json", "--markdown", "b.json"}),
            "credence: --markdown b.json: is the file of --baseline; name another file\n");
  fs::create_directories(folder_ / "logs");
  write("logs/a.csv", log);
  EXPECT_EQ(
      refusal({"check", "logs", "--out", "./logs"}),
      "credence: --out ./logs: is a folder of logs, of which the files of the report would be some; name "
      "another folder\n");
  EXPECT_NE(run({"check", "a.csv", "--out", "."}).err.find("a.csv: is there already and no file of a report"),
            std::string::npos);
  EXPECT_EQ(refusal({"check", "a.csv", "--junit", "folder"}),
            "credence: check: --junit: folder is a folder (credence help check)\n");
  EXPECT_EQ(refusal({"check", "a.csv", "--markdown", "nowhere/x"}),
            "credence: check: --markdown: there is no folder nowhere (credence help check)\n");
  EXPECT_EQ(read("a.csv"), log);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

// As of a truth that is the estimate: its bounds were "nan … nan".
TEST_F(CheckCommand, ErrorsThatAreAllZeroAreNoLaw) {
  std::string text = "run,step,estimate.x,truth.x,P.1.1\n";
  for (int run = 0; run < 30; ++run) {
    for (int step = 1; step <= 5; ++step) text += fmt::format("{0},{1},{1},{1},1\n", run, step);
  }
  write("a.csv", text);
  const Finished f = run({"check", "a.csv"});
  EXPECT_EQ(f.code, 0);
  EXPECT_EQ(f.out.find("nan"), std::string::npos) << f.out;
  EXPECT_NE(f.out.find("Every error is exactly zero: is the truth a copy of the estimate?"),
            std::string::npos)
      << f.out;
  const Json overall = json({"check", "a.csv", "--format", "json", "--quiet"})["nees"]["overall"];
  EXPECT_LT(overall["lower"], 1.0);
  EXPECT_GT(overall["upper"], 1.0);
}

// A truth of which a part was copied from the estimate: what is wrong alone is that part.
TEST_F(CheckCommand, ABlockWhoseErrorsAreAllZeroIsNamed) {
  for (const double scale : {1.0, 9.0}) {
    std::string text = "run,step,estimate.x,truth.x,estimate.yaw,truth.yaw,P.0.0,P.0.1,P.1.1\n";
    for (int run = 0; run < 30; ++run) {
      for (int step = 1; step <= 5; ++step)
        text += fmt::format("{0},{1},{2},0,{1},{1},{3},0,1\n", run, step,
                            std::sqrt(2.0) * std::cos(17.0 * run + 3.0 * step), 1.0 / scale);
    }
    write("a.csv", text);
    const Finished f = run({"check", "a.csv"});
    EXPECT_THAT(f.out,
                testing::HasSubstr("Every error of yaw is exactly zero: is that part of the truth a copy of "
                                   "the estimate?"));
    EXPECT_EQ(f.out.find("optimistic in x") != std::string::npos, scale > 1.0) << f.out;
  }
}

// The filter of the second version takes the process noise for a tenth of what it is.
TEST_F(CheckCommand, AGateFailsWhereAVersionIsWorseThanTheBaseline) {
  write("plane.toml", kPlane);
  const auto play = [&](const std::string& folder, const std::string& scale) {
    ASSERT_EQ(run({"run", "plane.toml", "--runs", "40", "--set", "filter.process_scale=" + scale, "--log",
                   folder, "--quiet"})
                  .code,
              0);
    write(folder + ".json", run({"check", folder, "--format", "json", "--quiet"}).out);
  };
  play("good", "1");
  play("bad", "0.1");
  const auto gate = [&](const std::string& logs, const std::string& baseline) {
    return run({"check", logs, "--baseline", baseline, "--fail-on-inconsistent", "--junit", "j.xml",
                "--markdown", "m.md", "--format", "json", "--quiet"});
  };
  const Finished worse = gate("bad", "good.json");
  EXPECT_EQ(worse.code, 1);
  const Json j = Json::parse(worse.out);
  EXPECT_TRUE(j["baseline"]["became_inconsistent"]);
  EXPECT_GE(j["baseline"]["worse"].size(), 2U);
  for (const Json& change : j["baseline"]["changes"]) {
    EXPECT_GT(change["lower"], change["part"] == "heading" ? 1.0 : 0.0);
  }
  EXPECT_NE(read("j.xml").find("failures=\"1\""), std::string::npos);
  EXPECT_NE(read("m.md").find("WORSE: it was consistent, and is optimistic"), std::string::npos)
      << read("m.md");
  EXPECT_EQ(gate("good", "good.json").code, 0);
  EXPECT_EQ(gate("bad", "bad.json").code, 0);   // as bad as before
  EXPECT_EQ(gate("good", "bad.json").code, 0);  // better
  EXPECT_NE(read("j.xml").find("failures=\"0\""), std::string::npos);
  std::filesystem::create_directory(folder_ / "renamed");
  for (int i = 0; i < 40; ++i) {
    std::filesystem::copy(folder_ / "bad" / fmt::format("run-{:06}.csv", i),
                          folder_ / "renamed" / fmt::format("drive-{}.csv", i));
  }
  EXPECT_EQ(gate("renamed", "bad.json").code, 1);  // of which nothing is known but the word
  EXPECT_EQ(run({"check", "bad", "--fail-on-inconsistent", "--junit", "j.xml", "--quiet"}).code, 1);
  EXPECT_EQ(read("j.xml").find("failures=\"0\""), std::string::npos);
  const Json compared = json({"compare", "good.json", "bad.json", "--format", "json"});
  EXPECT_EQ(compared["studies"][0]["changes"].size(), 0U);
  EXPECT_GE(compared["studies"][1]["changes"].size(), 2U);
  EXPECT_NE(run({"compare", "good.json", "bad.json"}).out.find("more optimistic in"), std::string::npos);
  for (const char* name : {"absent.json", "plane.toml"}) {
    const Finished refused = run({"check", "good", "--baseline", name});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find(std::string("--baseline ") + name), std::string::npos) << refused.err;
  }
}

TEST_F(CheckCommand, WritesAReport) {
  write("a.toml", kPlane);
  ASSERT_EQ(run({"run", "a.toml", "--log", "logs", "--quiet", "--runs", "20"}).code, 0);
  ASSERT_EQ(run({"check", "logs", "--out", "out", "--quiet"}).code, 0);
  const std::string page = read("out/index.html");
  for (const char* words : {"NEES of vehicle", "Whiteness", "every step as CSV"}) {
    EXPECT_NE(page.find(words), std::string::npos) << words;
  }
  EXPECT_TRUE(fs::exists(folder_ / "out" / "logs.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "logs-consistency.pdf"));
}

}  // namespace
}  // namespace credence::internal
