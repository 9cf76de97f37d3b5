// Which of its three kinds of input `credence tune` takes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class TuneCommand : public CommandTest {};

TEST_F(TuneCommand, OptionsOfOneKindOfInputAreRefusedForAnother) {
  write("a.toml", kMonobot);
  write("log.csv", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n");
  for (const char* input : {"a.toml", "log.csv", "tracking"}) {
    EXPECT_EQ(refusal({"tune", input, "--data", "x"}),
              "credence: --data and --robot: only of carpark and mrclam\n");
    EXPECT_EQ(refusal({"tune", input, "--robot", "1"}),
              "credence: --data and --robot: only of carpark and mrclam\n");
  }
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--free", "Q"},
                                                 {"--write", "tuned.toml"},
                                                 {"--set", "world.Q=[[1]]"},
                                                 {"--runs", "2"},
                                                 {"--steps", "2"},
                                                 {"--seed", "2"}}) {
    EXPECT_EQ(refusal({"tune", "log.csv", option[0], option[1]}),
              "credence: a log is no scenario: --free, --write, --set, --runs, --steps and --seed have no "
              "meaning for it\n");
  }
  EXPECT_EQ(refusal({"tune", "a.toml", "b.toml"}), "credence: tune: accepts exactly one scenario, or logs\n");
}

TEST_F(TuneCommand, AFileOrFolderOfItsNameIsMeantBeforeWhatTheProgramKnows) {
  fs::create_directories(folder_ / "carpark");
  write("tracking", "innovation.1,S.1.1\n0.5,1\n-0.5,1\n");
  EXPECT_THAT(refusal({"tune", "carpark"}), ::testing::Not(::testing::HasSubstr("CREDENCE_DATA")));
  EXPECT_THAT(refusal({"tune", "tracking", "--free", "Q"}), ::testing::HasSubstr("a log is no scenario"));
}

TEST_F(TuneCommand, NothingIsWrittenOverAndThatIsSaidAtOnce) {
  write("a.toml", kMonobot);
  write("there.toml", "kept");
  fs::create_symlink("nowhere", folder_ / "link.toml");
  for (const std::string file : {"there.toml", "link.toml"}) {
    EXPECT_EQ(refusal({"tune", "a.toml", "--write", file}),
              "credence: --write " + file + ": the file exists; nothing is written over\n");
  }
  EXPECT_EQ(read("there.toml"), "kept");
}

}  // namespace
}  // namespace credence::internal
