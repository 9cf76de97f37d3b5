#include <gmock/gmock.h>

#include <set>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ListCommand : public CommandTest {};

TEST_F(ListCommand, NamesTheScenarioFilesOfTheProject) {
  std::set<std::string> files, listed;
  for (const auto& file : std::filesystem::directory_iterator(source_folder() / "scenarios")) {
    if (file.path().extension() == ".toml") files.insert(file.path().stem().string());
  }
  const Json scenarios = json({"list", "scenarios", "--format", "json"})["scenarios"];
  for (const auto& entry : scenarios) {
    const std::string name = entry["name"], about = entry["about"];
    listed.insert(name);
    EXPECT_NE(about, "") << name;
    // A sweep says so, and is one.
    const std::string text = read(source_folder() / "scenarios" / (name + ".toml"));
    EXPECT_EQ(about.starts_with("(sweep) "), text.find("\n[sweep]") != std::string::npos) << name;
  }
  EXPECT_EQ(listed, files);
}

TEST_F(ListCommand, EveryWorldIsOneThatAScenarioMayName) {
  const Json document = json({"list", "worlds", "--format", "json"});
  EXPECT_EQ(document.size(), 1U) << "only what is asked for";
  EXPECT_GT(document["worlds"].size(), 5U);
  // The error of a wrong model lists what is accepted.
  const std::string refusal = run({"run", "figure1_two_landmarks", "--set", "world.model=moon"}).err;
  for (const auto& world : document["worlds"]) {
    EXPECT_THAT(refusal, HasSubstr("\"" + world["name"].get<std::string>() + "\""));
  }
}

TEST_F(ListCommand, EveryCommandHasItsHelp) {
  const Json commands = json({"list", "commands", "--format", "json"})["commands"];
  for (const auto& command : commands) {
    const std::string name = command["name"];
    const Finished help = run({"help", name});
    EXPECT_EQ(help.code, 0) << name;
    EXPECT_THAT(help.out, HasSubstr(command["about"].get<std::string>())) << name;
  }
}

TEST_F(ListCommand, TextHasOneTableForEachKind) {
  const std::string all = run({"list"}).out, worlds = run({"list", "worlds"}).out;
  for (const char* part : {"world.model of a scenario", "credence run NAME", "credence help COMMAND"}) {
    EXPECT_THAT(all, HasSubstr(part));
  }
  EXPECT_THAT(all, HasSubstr(worlds));
  EXPECT_THAT(worlds, Not(HasSubstr("credence help COMMAND")));
  EXPECT_EQ(run({"list", "planets"}).code, 2);
}

}  // namespace
}  // namespace credence::internal
