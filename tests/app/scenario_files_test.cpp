// Which scenario a name means: a file, or one that comes with the program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class ScenarioFiles : public CommandTest {
 protected:
  Finished short_run(const std::string& scenario) const {
    return run({"run", scenario, "--runs", "2", "--steps", "2", "--quiet", "--format", "json"});
  }
};

TEST_F(ScenarioFiles, AFolderOfItsNameDoesNotHideAScenarioOfTheProgram) {
  const Finished without = short_run("tracking");
  ASSERT_EQ(without.code, 0) << without.err;
  fs::create_directories(folder_ / "tracking");  // as `--out tracking` makes it
  const Finished beside = short_run("tracking");
  EXPECT_EQ(beside.code, 0) << beside.err;
  EXPECT_EQ(beside.out, without.out);
}

TEST_F(ScenarioFiles, AFileOfItsNameIsTheOneThatIsMeant) {
  write("tracking", "[world]\nmodel = \"monobot\"\n");
  const Finished f = short_run("tracking");
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_EQ(Json::parse(f.out)["scenario"]["world"]["model"], "monobot");
}

TEST_F(ScenarioFiles, WhatMayBeMeantIsSaidInOneSentence) {
  fs::create_directory(folder_ / "sub");
  write("sub/a.toml", "[world]\nmodel = \"monobot\"\n");
  const std::pair<const char*, const char*> cases[] = {
      {"planar_lop", "did you mean planar_loop, which comes with the program?"},
      {"sub/a", "did you mean sub/a.toml?"}};
  for (const auto& [name, proposal] : cases) {
    const Finished f = run({"run", name});
    EXPECT_EQ(f.code, 2);
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(f.err, std::string("credence: ") + name + ": no such scenario file; " + proposal + "\n");
  }
}

TEST_F(ScenarioFiles, ALoopOfLinksIsNotSaidToBeMissing) {
  const std::string why = ": cannot be read (Too many levels of symbolic links)\n";
  for (const char* name : {"x.toml", "tracking"}) fs::create_symlink(name, folder_ / name);
  for (const char* command : {"run", "sweep", "estimators"})
    EXPECT_EQ(run({command, "x.toml"}).err, "credence: x.toml" + why) << command;
  EXPECT_EQ(short_run("tracking").code, 0) << "a scenario of the program is not hidden by it";
}

TEST_F(ScenarioFiles, WhatIsNeitherIsRefusedWithWhatMayBeMeant) {
  fs::create_directories(folder_ / "folder");
  EXPECT_THAT(short_run("folder").err, HasSubstr("folder: is a directory; a scenario is a TOML file"));
  EXPECT_EQ(short_run("").err, "credence: the name of a scenario is empty\n");
  EXPECT_THAT(short_run("trackin").err, HasSubstr("did you mean tracking, which comes with the program?"));
  EXPECT_THAT(short_run("zzzzzzzz").err, HasSubstr("credence list names those that come with the program"));
  write("mine.toml", "[world]\nmodel = \"monobot\"\n");
  const Finished f = short_run("mine");
  EXPECT_EQ(f.code, 2);
  EXPECT_THAT(f.err, HasSubstr("did you mean mine.toml?"));
}

}  // namespace
}  // namespace credence::internal
