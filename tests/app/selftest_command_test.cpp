// `credence selftest` as a user types it.

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <string>
#include <thread>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class SelftestCommand : public CommandTest {};

TEST_F(SelftestCommand, SelftestGivesARateForEveryTest) {
  const Finished f = run({"selftest", "--studies", "100", "--format", "json", "--out", "st"});
  ASSERT_EQ(f.code, 0) << f.err;
  const Json j = Json::parse(f.out);
  EXPECT_TRUE(j["ok"]);
  EXPECT_GT(j["tests"].size(), 50U);
  for (const Json& test : j["tests"]) {
    EXPECT_TRUE(test["ok"]) << test;
    EXPECT_TRUE(test["nominal"] == 0.05 || test["nominal"].get<double>() < 0.011) << test;
    EXPECT_LE(test["lower"], test["measured"]) << test;
    EXPECT_GE(test["upper"], test["measured"]) << test;
    EXPECT_LE(test["lower"], test["nominal"]) << test;
  }
  ASSERT_EQ(j["wrong_filters"].size(), 13U);
  for (const Json& filter : j["wrong_filters"]) {
    EXPECT_TRUE(filter["ok"]) << filter["filter"];
    EXPECT_GT(filter["power"].size(), 15U) << filter["filter"];
  }
  EXPECT_GT(j["naive"][0]["measured"], 0.4);
  EXPECT_NE(read("st/index.html").find("<svg"), std::string::npos);
}

TEST_F(SelftestCommand, SelftestInterruptedProvesNothing) {
  const pid_t child = start({"selftest", "--studies", "1000000"});
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.out, "");
  EXPECT_NE(f.err.find("interrupted"), std::string::npos);
}

TEST_F(SelftestCommand, TooFewStudiesForARateAreRefused) {
  const Finished f = run({"selftest", "--studies", "99"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err,
            "credence: selftest: --studies 99: accepted are whole numbers from 100 to 100000000 (credence "
            "help selftest)\n");
}

}  // namespace
}  // namespace credence::internal
