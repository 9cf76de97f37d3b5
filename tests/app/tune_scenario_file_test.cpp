// `credence tune` of a scenario: its document, the scenario that it writes, what it refuses.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class TuneScenarioFile : public CommandTest {
 protected:
  /// A local level of q = 0.1 and r = 1, with a filter that has the right NIS and the wrong noise.
  std::string local_level() const {
    return write("level.toml", R"(
[world]
model = "linear"
F = [[1]]
H = [[1]]
Q = [[0.1]]
R = [[1]]
P0 = [[1]]
[filter]
Q = [[0.3]]
R = [[0.78]]
[study]
runs = 50
steps = 300
)");
  }
};

TEST_F(TuneScenarioFile, GivesTheDocumentOfTheContract) {
  const Json j = json({"tune", local_level(), "--free", "diag(Q),diag(R)", "--format", "json"});
  ASSERT_EQ(j["parameters"].size(), 2U);
  const Json &q = j["parameters"][0], &r = j["parameters"][1];
  EXPECT_EQ(q["name"], "filter.Q[1,1]");
  EXPECT_EQ(r["name"], "filter.R[1,1]");
  EXPECT_EQ(q["before"], 0.3);
  for (const auto& [p, truth] : {std::pair{q, 0.1}, std::pair{r, 1.0}}) {
    EXPECT_EQ(p["identifiable"], true);
    EXPECT_LT(p["lower"].get<double>(), p["value"].get<double>());
    EXPECT_LT(p["value"].get<double>(), p["upper"].get<double>());
    // Half the interval is two standard errors: it is off by less than five.
    const double width = p["upper"].get<double>() / p["lower"].get<double>();
    EXPECT_LT(p["value"].get<double>() / truth, std::pow(width, 1.25));
    EXPECT_GT(p["value"].get<double>() / truth, std::pow(width, -1.25));
    EXPECT_GT(p["steps_for_10_percent"].get<double>(), 100.0);
  }
  EXPECT_EQ(j["correlation"].size(), 2U);
  EXPECT_LT(j["log_score"]["before"].get<double>(), j["log_score"]["after"].get<double>());
  EXPECT_LT(j["log_score"]["likelihood_ratio_p_value"].get<double>(), 1e-20);
  EXPECT_EQ(j["held_out"]["verdict"], "consistent");
  EXPECT_EQ(j["held_out"]["runs"], 50);
  EXPECT_EQ(j["held_out"]["nis"]["expected"], 1.0);
  EXPECT_NEAR(j["held_out"]["nis"]["mean"].get<double>(), 1.0, 5.0 * std::sqrt(2.0 / 15000.0));
  EXPECT_GT(j["held_out"]["whiteness_p_value"].get<double>(), 1e-6);
  EXPECT_LT(j["held_out"]["before"]["whiteness_p_value"].get<double>(), 1e-6);
  EXPECT_EQ(j["ridge"].size(), 4U);
  EXPECT_TRUE(j["notes"].is_array());
}

TEST_F(TuneScenarioFile, WritesAScenarioThatRunsAndNeverOverAFile) {
  const std::string scenario = local_level();
  const Finished f = run({"tune", scenario, "--write", "tuned.toml", "--out", "page", "--quiet"});
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("filter.process_scale"), std::string::npos) << f.out;
  EXPECT_NE(f.out.find("NIS alone"), std::string::npos);
  EXPECT_NE(read("page/index.html").find("figure-surface"), std::string::npos);
  EXPECT_NE(read("page/index.html").find("figure-profiles"), std::string::npos);
  const Json after = json({"run", "tuned.toml", "--format", "json", "--quiet", "--seed", "9"});
  EXPECT_NEAR(after["nis"]["mean"].get<double>(), 1.0, 5.0 * std::sqrt(2.0 / 15000.0));
  const std::string kept = read("tuned.toml");
  const Finished again = run({"tune", scenario, "--write", "tuned.toml"});
  EXPECT_EQ(again.code, 2);
  EXPECT_NE(again.err.find("exists"), std::string::npos) << again.err;
  EXPECT_EQ(read("tuned.toml"), kept);
}

TEST_F(TuneScenarioFile, SaysThatNothingIsKnown) {
  const std::string scenario = local_level();
  const std::vector<std::string> unknown = {
      "tune", scenario, "--free", "diag(Q)", "--set", "world.Q=[[0.0]]", "--runs", "1", "--steps", "50"};
  std::vector<std::string> as_json = unknown;
  as_json.insert(as_json.end(), {"--format", "json"});
  const Json j = json(as_json);
  EXPECT_EQ(j["parameters"][0]["identifiable"], false);
  EXPECT_TRUE(j["parameters"][0]["value"].is_null());
  EXPECT_FALSE(j["parameters"][0]["null_reason"].empty());
  EXPECT_TRUE(j["held_out"].is_null());
  std::vector<std::string> writing = unknown;
  writing.insert(writing.end(), {"--write", "tuned.toml"});
  EXPECT_EQ(run(writing).code, 2);
}

TEST_F(TuneScenarioFile, ADelayIsPartOfTheWorldThatIsTuned) {
  for (const std::string& scenario : {local_level(), std::string("figure1_two_landmarks")}) {
    const auto score = [&](const std::string& delay) {
      const Json j = json({"tune", scenario, "--free", "R", "--runs", "20", "--steps", "30", "--set",
                           "noise.measurement_delay=" + delay, "--format", "json"});
      return j["log_score"]["before"].get<double>();
    };
    EXPECT_GT(std::abs(score("3") - score("0")), 1e-3) << scenario;
  }
}

TEST_F(TuneScenarioFile, RefusesWithTheKey) {
  const std::string scenario = local_level();
  EXPECT_NE(run({"tune", scenario, "--free", "S"}).err.find("\"S\""), std::string::npos);
  const Finished none = run({"tune", scenario, "--set", "world.Q=[[0]]", "--set", "filter.Q=[[0]]"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("Q is 0"), std::string::npos) << none.err;
}

TEST_F(TuneScenarioFile, AnInterruptionKeepsNothing) {
  const pid_t child = start({"tune", local_level(), "--runs", "5000", "--write", "tuned.toml", "--quiet"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.out, "");
  EXPECT_NE(f.err.find("credence: tune interrupted; nothing is kept of what is not done\n"),
            std::string::npos)
      << f.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tuned.toml"));
}

TEST_F(TuneScenarioFile, AScenarioOfTheProgramIsTunedByItsName) {
  const Json j = json(
      {"tune", "figure1_two_landmarks", "--free", "R", "--runs", "20", "--steps", "30", "--format", "json"});
  ASSERT_EQ(j["parameters"].size(), 1U);
  // The filter of the scenario is right: a factor of 1 is within five times half of the interval.
  const double value = j["parameters"][0]["value"], upper = j["parameters"][0]["upper"];
  EXPECT_LT(std::abs(std::log(value)), 2.5 * std::log(upper / value));
  EXPECT_EQ(run({"tune", "figure9_two_landmarks.toml"}).code, 2);
}

}  // namespace
}  // namespace credence::internal
