// What pages call logs, however they were named.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::StartsWith;

class LogName : public CommandTest {};

TEST_F(LogName, AFolderHasItsOwnNameHoweverItIsWritten) {
  std::string text = "run,step,innovation.1,S.1.1\n";
  for (int step = 1; step <= 40; ++step) {
    text += "0," + std::to_string(step) + (step % 3 == 0 ? ",1.5,1\n" : ",-0.5,1\n");
  }
  std::filesystem::create_directories(folder_ / "flights");
  write("flights/first.csv", text);
  for (const char* name : {"flights", "flights/", "./flights/.", "flights/../flights"}) {
    EXPECT_EQ(json({"tune", name, "--format", "json"})["name"], "flights") << name;
  }
  EXPECT_EQ(json({"tune", "flights/first.csv", "--format", "json"})["name"], "first");
  const Finished f = run({"tune", "flights/"});
  EXPECT_THAT(f.out.substr(f.out.find("flights")), StartsWith("flights: what innovations alone can tell"));
  EXPECT_EQ(run({"check", "flights/", "--out", "page", "--quiet"}).code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "page" / "flights.csv"));
}

TEST_F(LogName, AFileWhoseNameIsNoUtf8IsJudgedAndNamedAsFarAsItCanBe) {
  const std::string name = "caf\xe9";  // Latin-1
  write(name + ".csv",
        "run,step,estimate.x\xe9,truth.x\xe9,estimate.y,truth.y,P.1.1,P.1.2,P.2.2\n0,1,0.5,0,0.2,0,1,0,1\n"
        "0,2,-0.5,0,0.3,0,1,0,1\n0,3,0.1,0,0.1,0,1,0,1\n");
  EXPECT_TRUE(json({"check", name + ".csv", "--format", "json", "--quiet"})["blocks"].contains("x\uFFFD"));
  EXPECT_EQ(json({"check", "--list", name + ".csv", "--format", "json"})["logs"][0]["file"], "caf\uFFFD.csv");
  EXPECT_EQ(run({"check", name + ".csv", "--quiet", "--out", "page"}).code, 0);
}

}  // namespace
}  // namespace credence::internal
