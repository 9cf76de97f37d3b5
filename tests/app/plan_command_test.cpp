// `credence plan` as a user types it.

#include <gtest/gtest.h>
#include <signal.h>

#include <string>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

class PlanCommand : public CommandTest {};

TEST_F(PlanCommand, PlanGivesRunsForBothDirections) {
  write("a.toml", kMonobot);
  const Finished f = run({"plan", "a.toml", "--factor", "1.5", "--power", "0.8", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  for (const char* name : {"nees", "nis"}) {
    ASSERT_EQ(j[name]["detect"].size(), 2U);
    EXPECT_EQ(j[name]["detect"][0]["factor"], 1.5);
    for (const Json& detection : j[name]["detect"]) {
      EXPECT_GE(detection["power"], 0.8);
      EXPECT_GE(detection["runs"], 1);
      EXPECT_LE(detection["runs"], j["runs"]);
    }
  }
  EXPECT_EQ(j["nees"]["effective_steps_from"], "exact law");
  EXPECT_GT(j["seconds"], 0.0);
  EXPECT_GE(j["precision"]["runs"], 2);
}

// A pilot takes its time whatever the scenario, so that there are few of them.
TEST_F(PlanCommand, PlanOfASweepIsTheCostOfAllOfIt) {
  write("s.toml", kMonobot + "[sweep]\n\"filter.inflation\" = \"none, map\"\n");
  const Finished f = run({"plan", "s.toml", "--factor", "2", "--format", "json"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_EQ(j["sweep"]["configurations"], 2);
  EXPECT_EQ(j["sweep"]["planned"], 2);
  EXPECT_EQ(j["configurations"].size(), 2U);
  EXPECT_GT(j["sweep"]["seconds"], 0.0);
}

// Its first run would take the better part of a minute.
TEST_F(PlanCommand, AnInterruptionIsHeardAndSaid) {
  write("p.toml", kLongChunk);
  const pid_t child = start({"plan", "p.toml", "--quiet"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.out, "");
  EXPECT_EQ(f.err,
            "\ncredence: ending with what is done; once more ends at once\n"
            "credence: plan interrupted; nothing is kept of what is not done\n");
}

TEST_F(PlanCommand, OfALinearWorldItIsMadeToo) {
  const Finished f = run({"plan", scenario_file("linear"), "--set", "study.steps=20"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("NEES verdict"), std::string::npos);
}

TEST_F(PlanCommand, WhatCannotBeAnsweredIsRefusedBeforeAnyPilot) {
  // Its pilot would take the better part of a minute.
  write("p.toml", kLongChunk);
  const auto refused = [&](const char* option, const char* value) {
    return refusal({"plan", "p.toml", option, value});
  };
  EXPECT_EQ(refused("--factor", "1"),
            "credence: --factor = 1 is a consistent filter: there is nothing to detect\n");
  EXPECT_EQ(refused("--factor", "-1"), "credence: --factor = -1 must be a finite number > 0\n");
  EXPECT_EQ(refused("--factor", "inf"), "credence: --factor = inf must be a finite number > 0\n");
  EXPECT_EQ(refused("--power", "1"), "credence: --power = 1 must lie in (0, 1)\n");
  EXPECT_EQ(refused("--precision", "0"), "credence: --precision = 0 must be a finite number > 0\n");
}

}  // namespace
}  // namespace credence::internal
