// The linear and the tracking world by every command that takes a scenario.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class WorldsCommand : public CommandTest {
 protected:
  static std::string scenario(const std::string& name) {
    return source_folder() / "scenarios" / (name + ".toml");
  }
};

TEST_F(WorldsCommand, RunHasTheExactMomentsOfALinearWorld) {
  for (const char* name : {"linear", "tracking"}) {
    const Json j =
        json({"run", scenario(name), "--runs", "64", "--set", "study.steps=20", "--format", "json"});
    EXPECT_EQ(j["exact"]["nees"].size(), 20U) << name;
    EXPECT_EQ(j["covariance"]["trace"].size(), 20U) << name;
    EXPECT_TRUE(j["covariance"]["landmarks"].empty()) << name;
    EXPECT_FALSE(j["gain"].empty()) << name;
    EXPECT_TRUE(j["scenario"]["world"].contains("model")) << name;
  }
  const Json radar = json({"run", scenario("tracking_radar"), "--runs", "64", "--format", "json"});
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
  const Json late = json({"run", scenario("tracking_radar"), "--runs", "16", "--set",
                          "noise.measurement_delay=1", "--format", "json"});
  EXPECT_TRUE(late["bound"].contains("reason"));
  EXPECT_FALSE(late["battery"]["accuracy"][0].contains("bound"));
}

TEST_F(WorldsCommand, SweepResumesAndCheckJudgesTheLogs) {
  const std::vector<std::string> sweep = {"sweep",    scenario("linear"),
                                          "--runs",   "64",
                                          "--set",    "study.steps=10",
                                          "--set",    "sweep.filter.process_scale=0.5,1,2",
                                          "--out",    "out",
                                          "--format", "json"};
  const Json first = json(sweep), again = json(sweep);
  EXPECT_EQ(first, again);
  EXPECT_EQ(
      run({"run", scenario("tracking"), "--runs", "64", "--set", "study.steps=20", "--log", "logs"}).code, 0);
  const Json judged = json({"check", "logs", "--format", "json"});
  EXPECT_NEAR(judged["nees"]["mean"].get<double>(),
              json({"run", scenario("tracking"), "--runs", "64", "--set", "study.steps=20", "--format",
                    "json"})["nees"]["mean"]
                  .get<double>(),
              1e-9);
}

// The states of these worlds are no vectors: what their logs hold differs by the error in the judged chart.
TEST_F(WorldsCommand, WorldsOnGroupsRunSweepAndLog) {
  for (const char* name : {"localisation", "inertial"}) {
    const auto with = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.begin() + 1, {scenario(name), "--runs", "64", "--set", "study.steps=20",
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

// P of the invariant filters is that of an error in SE(2), and so must be what a log writes beside it.
TEST_F(WorldsCommand, LogsOfInvariantEstimatorsHoldTheErrorOfTheirP) {
  for (const char* estimator : {"ekf", "invariant", "invariant-left", "ukf-manifold"}) {
    const std::string logs = std::string("logs of ") + estimator;
    const std::string chosen = std::string("filter.estimator=") + estimator;
    const auto of_run = [&](std::vector<std::string> more) {
      std::vector<std::string> all{
          "run",   scenario("ukfm_slam2d"),     "--runs", "40",  "--set", "study.steps=60",
          "--set", "initial.position_std=0.01", "--set",  chosen};
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

TEST_F(WorldsCommand, ReportsShowNothingOfLandmarks) {
  for (const char* name : {"linear", "tracking", "tracking_radar"}) {
    ASSERT_EQ(run({"run", scenario(name), "--runs", "64", "--set", "study.steps=20", "--out", name}).code, 0);
    const std::string page = read(std::filesystem::path(name) / "index.html");
    EXPECT_THAT(page, HasSubstr(std::string(name) == "linear" ? "load" : "velocity.y"));
    for (const char* word : {"landmark", "Vehicle", "heading"})
      EXPECT_THAT(page, Not(HasSubstr(word))) << name;
  }
}

// H = 0 and R = 0: S is never positive definite.
TEST_F(WorldsCommand, AReportOfRunsThatAllFailedSaysSo) {
  const Finished f = run({"run", scenario("linear"), "--runs", "64", "--set", "world.H=[[0, 0, 0]]", "--set",
                          "world.R=[[0]]", "--out", "failed"});
  EXPECT_EQ(f.code, 3) << f.err;
  EXPECT_THAT(read("failed/index.html"), HasSubstr("64 of 64 runs failed"));
}

TEST_F(WorldsCommand, StabilityJudgesAnyF) {
  const std::string chain =
      source_folder() / "tests/analysis/stability/golden/linear_systems/unobserved_chain.toml";
  const Json grows = json({"stability", chain, "--format", "json"});
  EXPECT_EQ(grows["predicted_bounded"], false);
  EXPECT_EQ(grows["riccati"]["bounded"], false);
  EXPECT_TRUE(grows["noise_condition"].is_null());
  const Json motor = json({"stability", scenario("linear"), "--format", "json"});
  EXPECT_EQ(motor["riccati"]["bounded"], true);
  EXPECT_LT(motor["spectral_radius"].get<double>(), 1.0);
  const Finished text = run({"stability", scenario("tracking")});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, Not(HasSubstr("m²")));
  const Finished radar =
      run({"stability", scenario("tracking_radar"), "--set", "noise.detection_probability=1"});
  EXPECT_EQ(radar.code, 2);
  EXPECT_THAT(radar.err, HasSubstr("stability handles linear worlds and the planar one"));
}

TEST_F(WorldsCommand, PlanAndASingleRunWork) {
  EXPECT_EQ(run({"plan", scenario("linear"), "--set", "study.steps=20"}).code, 0);
  const Finished one = run({"run", scenario("linear"), "--only-run", "3"});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.out, HasSubstr("error of angle, speed, load ± 2σ"));
}

// The same filter in C, by binary frames, and built in: the pipe keeps every bit, and sums are in another
// order.
TEST_F(WorldsCommand, AFilterInAnotherLanguageHasItsVerdictThroughThePipe) {
  const std::string folder = (source_folder() / "examples/pipe").string(),
                    walk = folder + "/random_walk.toml";
  const Finished made =
      finish(start_program({"cc", "-std=c99", "-O1", "-o", "my_filter", folder + "/my_filter.c"}));
  if (made.code != 0) GTEST_SKIP() << "no C compiler: " << made.err;
  const std::string credence = credence_binary().string();
  const Finished piped = finish(start_program(
      {"sh", "-c",
       credence + " world " + walk + " --frames | ./my_filter | " + credence + " check - --format json"}));
  ASSERT_EQ(piped.code, 0) << piped.err;
  const Json judged = Json::parse(piped.out), wanted = json({"run", walk, "--format", "json"});
  EXPECT_EQ(judged["verdict"], wanted["verdict"]);
  for (const char* of : {"nees", "nis"}) {
    EXPECT_NEAR(judged[of]["mean"].get<double>(), wanted[of]["mean"].get<double>(), 1e-9) << of;
  }
}

TEST_F(WorldsCommand, FramesAreTheRowsOfTheText) {
  const std::vector<std::string> command = {"world", scenario("pendulum"), "--runs", "2", "--steps", "3"};
  std::vector<std::string> binary = command;
  binary.emplace_back("--frames");
  const std::string text = run(command).out, frames = run(binary).out;
  const auto body = [](const std::string& all) { return all.substr(all.find("run,step")); };
  const std::string names = body(text).substr(0, body(text).find('\n') + 1);
  EXPECT_THAT(frames, ::testing::StartsWith("# credence frames 1\n"));
  EXPECT_THAT(body(frames), ::testing::StartsWith(names));
  const auto columns = static_cast<std::size_t>(std::ranges::count(names, ',')) + 1;
  EXPECT_EQ(body(frames).size() - names.size(), 2 * 4 * columns * sizeof(double));
  EXPECT_EQ(std::ranges::count(body(text), '\n'), 1 + 2 * 4);
}

TEST_F(WorldsCommand, AStreamThatBreaksOffIsNamed) {
  const Finished broken =
      finish(start_program({"sh", "-c",
                            "printf '# credence frames 1\\nrun,step,error.x,P.1.1\\nabc' | " +
                                credence_binary().string() + " check -"}));
  EXPECT_NE(broken.code, 0);
  EXPECT_THAT(broken.err, HasSubstr("row 1 breaks off after 3 of 32 bytes"));
}

TEST_F(WorldsCommand, StabilityOfAPeriodicWorldIsThatOfItsPeriod) {
  write("periodic.toml",
        "[world]\nmodel = \"linear\"\nperiod = 2\nF = [[1, 0], [0, 1]]\nH = [[1, 0], [0, 1]]\n"
        "Q = [[0.1, 0], [0, 0.1]]\nR = [[1]]\nP0 = [[1, 0], [0, 1]]\n");
  const Finished seen = run({"stability", "periodic.toml"});
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_THAT(seen.out, HasSubstr("a step is here a whole period of 2"));
  EXPECT_TRUE(json({"stability", "periodic.toml", "--format", "json"})["predicted_bounded"]);
  EXPECT_FALSE(json(
      {"stability", "periodic.toml", "--set", "world.H=[[1, 0]]", "--format", "json"})["predicted_bounded"]);
}

}  // namespace
}  // namespace credence::internal
