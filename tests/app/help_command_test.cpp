// What the program says of itself: help, version, completion, and the projects that it begins.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class HelpCommand : public CommandTest {
 protected:
  bool has(const std::string& text, const std::string& part) const {
    return text.find(part) != std::string::npos;
  }

  /// What bash offers behind these words.
  std::string completed(const std::string& words) const {
    write("completion.bash", run({"completion", "bash"}).out);
    write("try.bash",
          "compopt() { :; }\nsource completion.bash\nCOMP_WORDS=(" + words +
              ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_credence\necho \"${COMPREPLY[@]}\" > completed\n");
    EXPECT_EQ(std::system(("cd " + folder_.path().string() + " && bash try.bash").c_str()), 0);
    return read("completed");
  }
};

TEST_F(HelpCommand, EveryCommandTellsHelpAndVersionAndIsListed) {
  const Json commands = json({"list", "commands", "--format", "json"})["commands"];
  ASSERT_GT(commands.size(), 15U);
  const std::string all = run({"help"}).out, manual = run({"help", "--man"}).out;
  EXPECT_EQ(run({}).code, 2);
  EXPECT_EQ(run({}).out, all);
  EXPECT_EQ(run({"--help"}).out, all);
  for (const Json& command : commands) {
    const std::string name = command["name"];
    EXPECT_TRUE(has(all, "\n  " + name + " ")) << name;
    EXPECT_TRUE(has(manual, ".SS credence " + name)) << name;
    const Finished help = run({"help", name});
    EXPECT_EQ(help.code, 0) << name;
    EXPECT_TRUE(has(help.out, "Usage: credence " + name)) << help.out;
    EXPECT_FALSE(has(help.out, "INT")) << help.out;
    EXPECT_EQ(run({name, "--help"}).out, help.out) << name;
    EXPECT_EQ(run({name, "--version"}).out, run({"--version"}).out) << name;
  }
  EXPECT_EQ(run({"version"}).out, run({"--version"}).out);
  EXPECT_TRUE(run({"--version"}).out.starts_with("0."));
}

TEST_F(HelpCommand, AScenarioThatComesWithTheProgramRunsByItsNameAnywhere) {
  EXPECT_EQ(json({"run", "figure1_two_landmarks", "--runs", "64", "--format", "json"})["runs"], 64);
  write("figure1_two_landmarks", "[world]\nmodel = \"monobot\"\nlandmarks = 3\n");
  EXPECT_EQ(json({"run", "figure1_two_landmarks", "--runs", "64", "--format", "json"})["state_dim"], 4)
      << "a file of that name is what is meant";
}

TEST_F(HelpCommand, InitWritesWhatRunsAsItIs) {
  EXPECT_EQ(run({"init", "loop", "--scenario", "--from", "figure1_two_landmarks"}).code, 0);
  EXPECT_EQ(json({"run", "loop.toml", "--runs", "64", "--format", "json"})["runs"], 64);
  EXPECT_NE(run({"init", "loop", "--scenario"}).err.find("loop.toml: is there already"), std::string::npos);
  EXPECT_EQ(run({"init", "radar", "--cpp"}).code, 0);
  EXPECT_TRUE(has(read("radar/CMakeLists.txt"), "add_executable(radar radar.cpp)"));
  EXPECT_FALSE(has(read("radar/radar.cpp"), "my_filter"));
  EXPECT_EQ(run({"init", "kalman", "--python"}).code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "kalman" / "kalman.py"));
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"init", "a/b", "--cpp"},
                                                {"init", "x"},
                                                {"init", "x", "--cpp", "--log"},
                                                {"init", "9x", "--log"}}) {
    EXPECT_EQ(run(wrong).code, 2) << wrong[1];
  }
}

TEST_F(HelpCommand, TheFilterThatWritesLogsIsFoundOptimistic) {
  if (std::system("python3 -c ''") != 0) GTEST_SKIP() << "no python3";
  ASSERT_EQ(run({"init", "kalman", "--log"}).code, 0);
  ASSERT_EQ(std::system(("cd " + (folder_ / "kalman").string() + " && python3 kalman.py").c_str()), 0);
  EXPECT_EQ(json({"check", "kalman/logs", "--format", "json", "--quiet"})["verdict"], "optimistic");
}

TEST_F(HelpCommand, BashCompletesCommandsOptionsValuesKeysAndScenarios) {
  EXPECT_TRUE(has(completed("credence sw"), "sweep"));
  EXPECT_TRUE(has(completed("credence run --fo"), "--format"));
  EXPECT_EQ(completed("credence run --format j"), "json\n");
  EXPECT_EQ(completed("credence run --set world.landmarks"), "world.landmarks=\n");
  EXPECT_TRUE(has(completed("credence run planar_l"), "planar_loop"));
  EXPECT_EQ(completed("credence completion f"), "fish\n");
  for (const char* shell : {"zsh", "fish"}) {
    EXPECT_TRUE(has(run({"completion", shell}).out, "world.landmarks=")) << shell;
  }
}

}  // namespace
}  // namespace credence::internal
