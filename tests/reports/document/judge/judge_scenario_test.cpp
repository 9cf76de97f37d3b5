#include "reports/document/judge/judge_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_io.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

Scenario monobot_with(double process_scale) {
  Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 300\nsteps = 20\nseed = 5\n",
      "mine.toml");
  scenario.filter.process_scale = process_scale;
  return scenario;
}

// Any field can be set by a program.
TEST(JudgeScenario, RefusesWhatNoFileCanSay) {
  const auto said = [](const std::function<void(Scenario&)>& change) {
    Scenario scenario = monobot_with(1.0);
    change(scenario);
    try {
      judge_scenario(scenario);
    } catch (const ScenarioError& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_THAT(said([](Scenario& s) { s.study.runs = 0; }), HasSubstr("runs = 0: must be an integer from 1"));
  EXPECT_THAT(said([](Scenario& s) { s.study.steps = -5; }), HasSubstr("steps = -5: must be"));
  EXPECT_THAT(said([](Scenario& s) { s.filter.process_scale = kNaN; }), HasSubstr("process_scale = nan"));
  EXPECT_THAT(said([](Scenario& s) { s = default_scenario("linear"); }), HasSubstr("F"));
}

// Where NEES and NIS stop the study before the other tests of the word speak, or the other way round.
TEST(JudgeScenario, OfAStopRuleEverythingIsThatOfTheRule) {
  int without_word = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario = monobot_with(1.0);
    scenario.study.seed = seed;
    scenario.stop.verdict = StopVerdict::either;
    scenario.filter.measurement_scale = 0.95;
    const JudgedFilter judged = judge_scenario(scenario);
    const bool wrong = is_inconsistent(judged.verdict());
    EXPECT_EQ(wrong, judged.p_value() <= 0.05) << seed;
    const bool undecided = judged.verdict() == Verdict::undecided;
    EXPECT_THAT(judged.says(), HasSubstr(wrong       ? std::string(to_string(judged.verdict()))
                                         : undecided ? "undecided by the rule that ends the study, "
                                                     : "no evidence"))
        << seed;
    without_word += wrong ? 0 : 1;
  }
  EXPECT_GT(without_word, 0);
  EXPECT_LT(without_word, 40);
}

TEST(JudgeScenario, TellsRightFromWrong) {
  const JudgedFilter right = judge_scenario(monobot_with(1.0)), wrong = judge_scenario(monobot_with(0.1));
  EXPECT_EQ(right.verdict(), Verdict::consistent) << right.text();
  EXPECT_GT(right.p_value(), 0.05);
  EXPECT_THAT(right.says(), HasSubstr("no evidence against the covariance"));
  EXPECT_TRUE(right.causes().empty());
  EXPECT_EQ(wrong.verdict(), Verdict::optimistic) << wrong.text();
  EXPECT_LT(wrong.p_value(), 0.05);
  EXPECT_GT(wrong.factor().lower, 1.0);
  EXPECT_EQ(wrong.factor().reason, "");
  ASSERT_FALSE(wrong.causes().empty());
  EXPECT_THAT(wrong.causes().front().name, HasSubstr("process noise"));
  EXPECT_TRUE(right.failures().empty());
}

TEST(JudgeScenario, ToldAsTextJsonAndPage) {
  const JudgedFilter judged = judge_scenario(monobot_with(0.1), {.threads = 2});
  EXPECT_THAT(judged.text(), HasSubstr("mine"));
  const auto json = nlohmann::json::parse(judged.json());
  EXPECT_EQ(json["verdict"], to_string(judged.verdict()));
  EXPECT_EQ(json["battery"]["causes"][0]["cause"], judged.causes().front().name);
  EXPECT_EQ(json["battery"]["scale"]["covariance"]["factor"], judged.factor().value);
  EXPECT_EQ(judged.json(), judge_scenario(monobot_with(0.1)).json()) << "whatever the threads";
  const TemporaryFolder folder;
  judged.write_report(folder / "out");
  EXPECT_THAT(folder.read("out/index.html"), HasSubstr("optimistic"));
}

TEST(JudgeScenario, StoppedBeforeTheFirstRunsIsAnError) {
  static constexpr std::atomic<bool> kStop{true};
  EXPECT_THROW(judge_scenario(monobot_with(1.0), {.stop = &kStop}), std::runtime_error);
}

TEST(JudgeScenario, TellsHowFarItIsAndIsStoppedOnTheWay) {
  std::vector<std::int64_t> told;
  std::atomic<bool> stop{false};
  const auto progress = [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(total, 300);
    told.push_back(done);
  };
  EXPECT_TRUE(judge_scenario(monobot_with(1.0), {.threads = 1, .progress = progress}).complete());
  EXPECT_EQ(told, (std::vector<std::int64_t>{64, 128, 192, 256, 300}));
  const auto enough = [&](std::int64_t done, std::int64_t) { stop = done >= 128; };
  const JudgedFilter part =
      judge_scenario(monobot_with(1.0), {.threads = 1, .stop = &stop, .progress = enough});
  EXPECT_FALSE(part.complete());
  EXPECT_EQ(nlohmann::json::parse(part.json())["runs"], 128);
}

TEST(JudgeScenario, NamesRunsThatFailed) {
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"planar\"\n[noise]\nspeed_std = 30.0\nturn_rate_std = 20.0\n[study]\nruns = "
      "40\nsteps = 60\n",
      "hard.toml");
  const JudgedFilter judged = judge_scenario(scenario);
  const auto json = nlohmann::json::parse(judged.json());
  ASSERT_EQ(judged.failures().size(), json["outcomes"]["failures"].size());
  for (std::size_t i = 0; i < judged.failures().size(); ++i) {
    EXPECT_EQ(json["outcomes"]["failures"][i]["run"], judged.failures()[i].run);
    EXPECT_EQ(json["outcomes"]["failures"][i]["outcome"], judged.failures()[i].outcome);
  }
}

}  // namespace
}  // namespace credence::internal
