#include <gmock/gmock.h>

#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class InitCommand : public CommandTest {};

TEST_F(InitCommand, EveryScenarioOfTheProgramMayBeTheBeginning) {
  const Json scenarios = json({"list", "scenarios", "--format", "json"})["scenarios"];
  for (const auto& scenario : scenarios) {
    const std::string from = scenario["name"];
    const Finished made = run({"init", "mine_" + from, "--scenario", "--from", from});
    EXPECT_EQ(made.code, 0) << made.err;
    // The command that it names is the one for its kind.
    const bool sweep = scenario["about"].get<std::string>().starts_with("(sweep) ");
    EXPECT_THAT(made.out, HasSubstr(std::string("  credence ") + (sweep ? "sweep" : "run") + " mine_" + from +
                                    ".toml"));
    EXPECT_THAT(read("mine_" + from + ".toml"),
                HasSubstr(read(source_folder() / "scenarios" / (from + ".toml"))));
  }
}

TEST_F(InitCommand, NothingIsWrittenOverAndNothingByHalves) {
  fs::create_directory(folder_ / "radar");
  write("radar/radar.cpp", "mine");
  const Finished refused = run({"init", "radar", "--cpp"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_EQ(refused.err, "credence: radar/radar.cpp: is there already; nothing was written\n");
  EXPECT_EQ(read("radar/radar.cpp"), "mine");
  EXPECT_FALSE(fs::exists(folder_ / "radar" / "CMakeLists.txt"));
}

TEST_F(InitCommand, ANameIsOneOfAFileATargetAndAModule) {
  for (const char* name : {"", "9x", "a-b", "a b", "../a", "ä"}) {
    const Finished refused = run({"init", name, "--python"});
    EXPECT_EQ(refused.code, 2) << name;
    EXPECT_THAT(refused.err, HasSubstr("a name has letters, digits and _, and begins with a letter"));
  }
  EXPECT_EQ(run({"init", "_a9", "--python"}).code, 0);
  EXPECT_EQ(run({"init", "numpy", "--python"}).err,
            "credence: init numpy: numpy.py would be imported in the place of the module numpy; choose "
            "another name\n");
  EXPECT_FALSE(fs::exists(folder_ / "numpy.py"));
}

TEST_F(InitCommand, AMisspelledKindIsProposed) {
  EXPECT_EQ(run({"init", "x", "--python", "--scenari"}).err,
            "credence: init: --scenari is not expected; did you mean --scenario? (credence help init)\n");
}

TEST_F(InitCommand, WhatIsOfNoEffectIsRefused) {
  EXPECT_EQ(run({"init", "x", "--scenario", "--from", "moon"}).err,
            "credence: --from moon: no such scenario; credence list scenarios names all\n");
  const Finished refused = run({"init", "x", "--cpp", "--from", "planar_loop"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_EQ(refused.err, "credence: init: --from requires --scenario (credence help init)\n");
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

}  // namespace
}  // namespace credence::internal
