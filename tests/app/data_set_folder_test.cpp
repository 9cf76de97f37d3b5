// Where the commands that replay look for a data set, and settings of a replay.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class DataSetFolder : public CommandTest {};

TEST_F(DataSetFolder, IsThatOfItsNameIfThereIsOneAndElseTheOneThatIsNamed) {
  fs::create_directories(folder_ / "data");
  EXPECT_EQ(refusal({"replay", "carpark", "--data", "data"}),
            "credence: data/data_set.mat: there is no such file\n");
  write("data/carpark", "a file is no folder");
  EXPECT_EQ(refusal({"tune", "carpark", "--data", "data"}),
            "credence: data/data_set.mat: there is no such file\n");
  fs::remove(folder_ / "data/carpark");
  fs::create_directories(folder_ / "data/carpark");
  fs::create_directories(folder_ / "data/mrclam7");
  for (const char* command : {"replay", "tune"}) {
    EXPECT_EQ(refusal({command, "carpark", "--data", "data"}),
              "credence: data/carpark/data_set.mat: there is no such file\n");
    EXPECT_THAT(refusal({command, "mrclam", "--robot", "1", "--data", "data"}),
                ::testing::StartsWith("credence: data/mrclam7/"));
  }
}

TEST_F(DataSetFolder, IsNamedByTheEnvironmentWhereNoOptionDoes) {
  fs::create_directories(folder_ / "named");
  const auto said = [&](const std::string& arguments) {
    return finish(start_program(
                      {"sh", "-c",
                       "exec env CREDENCE_DATA=named " + credence_binary().string() + " " + arguments}))
        .err;
  };
  for (const std::string command : {"replay", "tune"}) {
    EXPECT_EQ(said(command + " carpark"), "credence: named/data_set.mat: there is no such file\n");
    EXPECT_EQ(said(command + " carpark --data ."), "credence: ./data_set.mat: there is no such file\n");
  }
}

TEST_F(DataSetFolder, IsNamedOnceOfTheCarPark) {
  for (const char* command : {"replay", "tune"}) {
    EXPECT_EQ(
        refusal({command, "carpark"}),
        "credence: --data: name the folder with the data set, or set CREDENCE_DATA (docs/datasets.md)\n");
    EXPECT_EQ(refusal({command, "carpark", "--data", "a", "--data", "b"}),
              "credence: --data: the car park was driven once, name one folder\n");
  }
}

TEST_F(DataSetFolder, SettingsOfAReplayAreNamedByTheirKey) {
  const auto with = [&](const std::string& setting) {
    return refusal({"replay", "carpark", "--data", "nowhere", "--set", setting});
  };
  EXPECT_EQ(with("noise.range_std"), "credence: --set noise.range_std: accepted is section.key=value\n");
  EXPECT_THAT(with("noise.range_sdt=1"), ::testing::HasSubstr("noise.range_sdt"));
  EXPECT_THAT(with("noise.range_std=-1"), ::testing::HasSubstr("noise.range_std"));
}

}  // namespace
}  // namespace credence::internal
