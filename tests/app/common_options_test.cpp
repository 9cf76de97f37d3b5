// The options that commands on a scenario share.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class CommonOptionsTest : public CommandTest {
 protected:
  void SetUp() override { write("a.toml", kMonobot); }
};

TEST_F(CommonOptionsTest, OptionsOfTheStudyHaveTheLastWordAndLaterSettingsTheLater) {
  const Json j = json({"run",      "a.toml",
                       "--runs",   "70",
                       "--steps",  "6",
                       "--seed",   "4",
                       "--set",    "study.runs=50",
                       "--set",    "study.steps=5",
                       "--set",    "study.seed=3",
                       "--set",    "noise.process_variance=0.3",
                       "--set",    "noise.process_variance=0.2",
                       "--format", "json"});
  EXPECT_EQ(j["runs"], 70);
  EXPECT_EQ(j["steps"], 6);
  EXPECT_EQ(j["scenario"]["study"]["seed"], 4);
  EXPECT_EQ(j["scenario"]["noise"]["process_variance"], 0.2);
}

TEST_F(CommonOptionsTest, APageOfOthersIsSeenBeforeAnythingIsPlayed) {
  fs::create_directories(folder_ / "page");
  write("page/index.html", "mine");
  const Finished f = run({"run", "a.toml", "--out", "page"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("page/index.html: is there already and no page of a report"), std::string::npos)
      << f.err;
  EXPECT_EQ(read("page/index.html"), "mine");
  EXPECT_FALSE(fs::exists(folder_ / "page/results.sqlite"));
}

TEST_F(CommonOptionsTest, ASettingIsOneWordAndTakesNoScenarioForAnother) {
  // CLI11 by itself would give every word behind --set to it.
  EXPECT_EQ(json({"run", "--set", "study.runs=70", "a.toml", "--format", "json"})["runs"], 70);
  EXPECT_EQ(run({"run", "a.toml", "--set", "study.runs"}).code, 2);
}

TEST_F(CommonOptionsTest, ANumberThatIsTooLargeOrMissingIsNotMadeAnother) {
  for (const char* option : {"--runs", "--steps", "--seed"}) {
    for (const char* command : {"run", "world", "stability"}) {
      if (command == std::string("stability") && option == std::string("--runs")) continue;
      const std::string begin = "credence: " + std::string(command) + ": " + option,
                        end = " (credence help " + std::string(command) + ")\n";
      for (const char* value : {"-1", "x"}) {
        const Finished bad = run({command, "a.toml", option, value});
        EXPECT_EQ(bad.code, 2);
        EXPECT_TRUE(bad.err.starts_with(begin + " " + value + ": accepted are whole numbers from "))
            << bad.err;
      }
      const std::string large = "99999999999999999999";
      const Finished refused = run({command, "a.toml", option, large});
      EXPECT_EQ(refused.code, 2);
      EXPECT_EQ(refused.err, option == std::string("--seed")
                                 ? begin + ": " + large + " is too large" + end
                                 : begin + " " + large + ": accepted are whole numbers from 1 to " +
                                       (option == std::string("--runs") ? "1000000000" : "10000000") + end);
      // As of a variable of a script that is not set.
      const Finished missing = run({command, "a.toml", option, ""});
      EXPECT_EQ(missing.code, 2);
      EXPECT_EQ(missing.err, begin + ": the value is missing" + end);
    }
  }
  EXPECT_EQ(json({"run", "a.toml", "--runs", "2", "--seed", "9223372036854775807", "--format",
                  "json"})["scenario"]["study"]["seed"],
            9223372036854775807);
}

TEST_F(CommonOptionsTest, AValueThatIsMissingIsNotPassedOver) {
  // Nothing would be stored, written, or compared with.
  const std::vector<std::pair<std::vector<std::string>, std::string>> calls = {
      {{"run", "a.toml", "--out"}, "run: --out"},
      {{"run", "a.toml", "--log"}, "run: --log"},
      {{"check", "a.csv", "--baseline"}, "check: --baseline"},
      {{"check", "a.csv", "--instance"}, "check: --instance"},
      {{"tune", "a.toml", "--write"}, "tune: --write"}};
  for (auto [arguments, option] : calls) {
    arguments.emplace_back("");
    EXPECT_EQ(refusal(arguments),
              "credence: " + option + ": the value is missing (credence help " + arguments.front() + ")\n");
  }
  EXPECT_EQ(refusal({"check", "a.csv", "--within", "nan"}),
            "credence: check: --within: nan is no number (credence help check)\n");
}

TEST_F(CommonOptionsTest, FiguresAreWhatIsAskedForAndAWrongWordIsRefusedAtOnce) {
  ASSERT_EQ(run({"run", "a.toml", "--out", "both", "--quiet"}).code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "both/figures/a-run.svg"));
  EXPECT_TRUE(fs::exists(folder_ / "both/figures/a-run.pdf"));
  ASSERT_EQ(run({"run", "a.toml", "--out", "one", "--quiet", "--figures", "svg"}).code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "one/figures/a-run.svg"));
  EXPECT_FALSE(fs::exists(folder_ / "one/figures/a-run.pdf"));
  const Finished f = run({"run", "a.toml", "--out", "none", "--figures", "svg,eps"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err,
            "credence: run: --figures: 'eps' is none of svg, pdf, png, pgf, one-column, two-columns, serif "
            "(credence help run)\n");
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

TEST_F(CommonOptionsTest, AFolderThatCannotBeIsToldOfBeforeAnythingIsDone) {
  write("file", "kept");
  for (const std::vector<std::string>& command : {std::vector<std::string>{"run", "a.toml"},
                                                  {"tune", "a.toml"},
                                                  {"compare", "a", "b"},
                                                  {"stability", "a.toml"},
                                                  {"estimators", "a.toml"},
                                                  {"claims"},
                                                  {"timing"},
                                                  {"selftest"},
                                                  {"check", "a.csv"},
                                                  {"report", "a"},
                                                  {"merge", "a"},
                                                  {"submit", "a.toml", "--tasks", "1"}}) {
    for (const auto& [out, why] : {std::pair{"file", "file is no folder"},
                                   std::pair{"file/sub", "file/sub cannot be made: file is no folder"}}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"--out", out});
      EXPECT_EQ(refusal(arguments),
                fmt::format("credence: {0}: --out: {1} (credence help {0})\n", command.front(), why));
    }
  }
  EXPECT_EQ(refusal({"run", "a.toml", "--log", "file"}),
            "credence: run: --log: file is no folder (credence help run)\n");
  EXPECT_EQ(refusal({"tune", "a.toml", "--write", "no/where.toml"}),
            "credence: tune: --write: there is no folder no (credence help tune)\n");
  EXPECT_EQ(read("file"), "kept");
}

TEST_F(CommonOptionsTest, AnOptionThatWouldDoNothingIsRefused) {
  write("s.toml", kMonobotSweep);
  const std::vector<std::pair<std::vector<std::string>, std::string>> calls = {
      {{"run", "a.toml", "--figures", "svg"}, "--figures requires --out"},
      {{"run", "a.toml", "--log-format", "npz"}, "--log-format requires --log"},
      {{"run", "a.toml", "--fresh"}, "--fresh: without --out or --log there is nothing to discard"},
      {{"run", "a.toml", "--only-run", "1", "--fail-on-inconsistent"},
       "--fail-on-inconsistent excludes --only-run"},
      {{"sweep", "s.toml", "--shard", "1/2", "--fail-on-inconsistent"}, "a shard has no verdict"},
      {{"stability", "a.toml", "--loops", "5"}, "a.toml: --loops: only of planar worlds; this one is linear"},
      {{"stability", "a.toml", "--seed", "5"}, "a.toml: --seed: only of planar worlds; this one is linear"},
      {{"stability", scenario_file("planar_stability"), "--horizon", "50"},
       "--horizon: only of linear worlds; this one is planar"},
      {{"replay", "carpark", "--robot", "2"}, "--robot: only of mrclam"},
      {{"tune", "carpark", "--robot", "2"}, "--robot: only of mrclam"},
      {{"estimators", scenario_file("estimator_map"), "--fail-on-inconsistent"},
       "[sweep]: --fail-on-inconsistent is of one study"}};
  for (const auto& [arguments, says] : calls) {
    const std::string said = refusal(arguments);
    EXPECT_NE(said.find(says), std::string::npos) << said;
  }
}

TEST_F(CommonOptionsTest, AnInconsistentFilterIsAFailureWhereThatIsAskedFor) {
  for (const char* scale : {"0.5", "1.0", "2.0"}) {
    std::vector<std::string> arguments{"run", "a.toml", "--set",
                                       std::string("filter.measurement_scale=") + scale};
    EXPECT_EQ(run(arguments).code, 0) << scale;
    arguments.emplace_back("--fail-on-inconsistent");
    EXPECT_EQ(run(arguments).code, std::string(scale) == "1.0" ? 0 : 1) << scale;
  }
}

}  // namespace
}  // namespace credence::internal
