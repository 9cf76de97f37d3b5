// `credence stability` as a user types it: the built binary, its documents, its exit codes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class StabilityCommand : public CommandTest {};

TEST_F(StabilityCommand, GivesTheDocumentOfTheContract) {
  const Finished f = run({"stability", scenario_file("figure2_two_landmarks"), "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_EQ(f.err, "");
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["state_dim"], 3);
  EXPECT_EQ(j["rank"]["controllability"], 1);
  EXPECT_EQ(j["rank"]["observability"], 2);
  EXPECT_EQ(j["rank"]["inflation"], 2);
  EXPECT_EQ(j["rank"]["noise_total"], 3);
  ASSERT_EQ(j["closed_loop_eigenvalues"].size(), 3U);
  EXPECT_NEAR(j["closed_loop_eigenvalues"][0][0].get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(j["spectral_radius"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(j["riccati"]["bounded"], false);
  EXPECT_NEAR(j["riccati"]["growth_exponent"].get<double>(), 1.0, 0.01);
  for (const char* key : {"trace", "residual"}) EXPECT_TRUE(j["riccati"][key].is_number()) << key;
  EXPECT_EQ(j["riccati"]["kind"], "none");
  EXPECT_EQ(j["predicted_bounded"], false);
  const Json& condition = j["noise_condition"];
  EXPECT_EQ(condition["bounded"], false);
  EXPECT_TRUE(condition["trace_bound"].is_null());
  EXPECT_FALSE(condition["null_reason"].empty());
  EXPECT_GT(condition["rate"].get<double>(), 0.0);
  EXPECT_LE(condition["rate"].get<double>(), condition["growth_per_step"].get<double>());
  EXPECT_EQ(condition["direction"].size(), 3U);
  EXPECT_EQ(condition["direction_name"], "common translation");
  EXPECT_EQ(j["paper_condition_holds"], true);
  EXPECT_EQ(j["unobservable"], Json::array({"common translation"}));
  EXPECT_EQ(j["long_horizon"]["verdict"], "growing");
  EXPECT_NEAR(j["long_horizon"]["growth_per_step"].get<double>(), 0.1, 2e-4);
}

TEST_F(StabilityCommand, TextSaysBoundedAndTheReportStandsAlone) {
  const Finished f = run({"stability", scenario_file("figure3_two_landmarks"), "--out", "page"});
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("common translation"), std::string::npos) << f.out;
  EXPECT_NE(f.out.find("bounded"), std::string::npos);
  EXPECT_EQ(f.out.find("unbounded"), std::string::npos) << f.out;
  EXPECT_NE(f.out.find("tr P after an update never exceeds"), std::string::npos) << f.out;
  EXPECT_NE(read("page/index.html").find("Stability of figure3_two_landmarks"), std::string::npos);
}

TEST_F(StabilityCommand, RefusesWhatCannotBeFollowedNamingFileAndKey) {
  const std::string file = scenario_file("planar_stability");
  for (const char* setting : {"world.dt=7e10", "world.path_radius=1e20"}) {
    const Finished f = run({"stability", file, "--set", setting});
    EXPECT_EQ(f.code, 2) << setting;
    EXPECT_NE(f.err.find(file + ": world.path_radius"), std::string::npos) << f.err;
  }
}

TEST_F(StabilityCommand, AnRThatIsNotPositiveDefiniteIsRefusedByTheKeysItIsMadeOf) {
  write("linear.toml",
        "[world]\nmodel = \"linear\"\nF = [[1]]\nH = [[1]]\nQ = [[1]]\nR = [[0]]\nP0 = [[1]]\n");
  const std::string monobot = scenario_file("figure3_two_landmarks"), tracking = scenario_file("tracking");
  const auto says = [this](std::vector<std::string> settings, const std::string& keys) {
    const std::string file = settings.front();
    settings.insert(settings.begin(), "stability");
    EXPECT_EQ(
        refusal(settings),
        "credence: " + file + ": R of the filter is not positive definite: it follows from " + keys + "\n");
  };
  says({monobot, "--set", "noise.measurement_variance=0", "--set", "study.steps=1"},
       "noise.measurement_variance, filter.measurement_scale");
  says({tracking, "--set", "noise.position_std=1e-300"}, "noise.position_std, filter.measurement_scale");
  says({"linear.toml"}, "world.R, filter.R, filter.measurement_scale");
}

TEST_F(StabilityCommand, WhatIsOutOfRangeIsNoNan) {
  const std::string file = scenario_file("figure3_two_landmarks");
  for (const std::vector<std::string>& settings :
       {std::vector<std::string>{"filter.process_scale=1e19", "study.steps=20"},
        {"filter.measurement_scale=1e-320"}}) {
    std::vector<std::string> arguments = {"stability", file};
    for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 0) << f.err;
    EXPECT_THAT(f.out, AllOf(HasSubstr("solution: undecided;"), Not(HasSubstr("nan"))));
  }
}

TEST_F(StabilityCommand, FollowsAPlanarWorldAlongItsPath) {
  const Finished f = run({"stability", scenario_file("planar_stability"), "--set", "world.landmarks=4",
                          "--loops", "6", "--format", "json", "--out", "plane", "--quiet"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["state_dim"], 11);
  EXPECT_EQ(j["rank"]["controllability"], 3);
  EXPECT_EQ(j["rank"]["observability"], 8);
  EXPECT_EQ(j["rank"]["observability_at_estimate"], 9);
  EXPECT_EQ(j["closed_loop_eigenvalues"].size(), 11U);
  EXPECT_EQ(j["predicted_bounded"], false);  // the pairwise sum: theory, section 5
  EXPECT_EQ(j["filters"].size(), 10U);       // five solutions, at the truth and at the estimate
  for (const char* key : {"bounded", "growth_exponent", "trace", "residual", "kind"}) {
    EXPECT_TRUE(j["riccati"].contains(key)) << key;
  }
  EXPECT_NE(read("plane/index.html").find("rotation about the origin"), std::string::npos);
}

// Where the solutions are swept each point has its own alone, else all that there are.
TEST_F(StabilityCommand, ASweepOfSolutionsFollowsEachOnce) {
  const Finished f = run({"stability", scenario_file("map_solutions"), "--set", "world.landmarks=2",
                          "--loops", "4", "--format", "json", "--quiet"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json configurations = Json::parse(f.out)["configurations"];
  ASSERT_EQ(configurations.size(), 5U);
  for (const Json& each : configurations) {
    ASSERT_EQ(each["filters"].size(), 2U);  // at the truth and at the estimate
    EXPECT_EQ(each["filters"][0]["solution"], each["scenario"]["filter"]["solution"]);
  }
}

// Hours of either kind of world, and of a sweep.
TEST_F(StabilityCommand, AnInterruptionIsHeardAndSaid) {
  const std::string linear = scenario_file("linear"), plane = scenario_file("planar_stability");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"stability", linear, "--horizon", "10000000"},
        {"stability", plane, "--loops", "100000"},
        {"stability", scenario_file("planar_table"), "--loops", "100000", "--threads", "2"}}) {
    const pid_t child = start(arguments);
    wait_until_caught(child);
    kill(child, SIGINT);
    const Finished f = finish(child);
    EXPECT_EQ(f.code, 130) << arguments[1];
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(f.err,
              "\ncredence: ending with what is done; once more ends at once\n"
              "credence: stability interrupted; nothing is kept of what is not done\n");
  }
}

TEST_F(StabilityCommand, RefusesAConstantInflationInThePlane) {
  const Finished f = run({"stability", scenario_file("planar_stability"), "--set", "filter.inflation=rank"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.out, "");
  EXPECT_NE(f.err.find("filter.inflation"), std::string::npos) << f.err;
}

TEST_F(StabilityCommand, BadInputIsTwo) {
  EXPECT_EQ(run({"stability", "missing.toml"}).code, 2);
  EXPECT_EQ(run({"stability"}).code, 2);
  EXPECT_EQ(run({"stability", scenario_file("figure3_two_landmarks"), "--horizon", "0"}).code, 2);
  EXPECT_EQ(run({"stability", scenario_file("planar_stability"), "--loops", "1"}).code, 2);
  EXPECT_EQ(
      run({"stability", scenario_file("figure3_two_landmarks"), "--set", "noise.measurement_variance=0"})
          .code,
      2);
  EXPECT_EQ(run({"stability", "--help"}).code, 0);
  const Finished missing =
      run({"stability", scenario_file("figure3_two_landmarks"), "--set", "noise.detection_probability=0.5"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("noise.detection_probability"), std::string::npos) << missing.err;
}

TEST_F(StabilityCommand, SweepDrawsTheMapOfRanks) {
  const Finished f = run({"sweep", scenario_file("rank_map"), "--set", "sweep.world.landmarks=1:3", "--set",
                          "sweep.study.seed=1", "--out", "map", "--format", "json", "--quiet"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json map = Json::parse(f.out)["rank_map"];
  ASSERT_EQ(map["groups"].size(), 8U);
  for (const Json& group : map["groups"]) EXPECT_EQ(group["exact_errs"], 0) << group;
  for (const Json& cell : map["cells"]) {
    const bool touches_all = cell["inflation_range"] == "generic" || cell["inflation_range"] == "map";
    const bool errs = cell["measured_bounded"] != cell["paper_condition_holds"];
    EXPECT_EQ(errs, cell["observability"] == "partial" && touches_all &&
                        cell["inflation_rank"] == cell["observability_rank"])
        << cell;
  }
  EXPECT_NE(read("map/index.html").find("figure-rank-map"), std::string::npos);
  EXPECT_NE(read("map/sweep.csv").find("paper_condition_holds"), std::string::npos);
}

TEST_F(StabilityCommand, StabilityJudgesAnyF) {
  const std::string chain =
      source_folder() / "tests/analysis/stability/golden/linear_systems/unobserved_chain.toml";
  const Json grows = json({"stability", chain, "--format", "json"});
  EXPECT_EQ(grows["predicted_bounded"], false);
  EXPECT_EQ(grows["riccati"]["bounded"], false);
  EXPECT_TRUE(grows["noise_condition"].is_null());
  const Json motor = json({"stability", scenario_file("linear"), "--format", "json"});
  EXPECT_EQ(motor["riccati"]["bounded"], true);
  EXPECT_LT(motor["spectral_radius"].get<double>(), 1.0);
  const Finished text = run({"stability", scenario_file("tracking")});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, Not(HasSubstr("m²")));
  const Finished radar =
      run({"stability", scenario_file("tracking_radar"), "--set", "noise.detection_probability=1"});
  EXPECT_EQ(radar.code, 2);
  EXPECT_THAT(radar.err, HasSubstr("stability handles linear worlds and the planar one"));
}

TEST_F(StabilityCommand, StabilityOfAPeriodicWorldIsThatOfItsPeriod) {
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
