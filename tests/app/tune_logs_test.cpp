// `credence tune` of logs.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class TuneLogs : public CommandTest {};

/// A local level of q = 0.1 and r = 1, with a filter of three times that q and of an r that makes up for it.
const std::string kLocalLevel =
    "[world]\nmodel = \"linear\"\nF = [[1]]\nH = [[1]]\nQ = [[0.1]]\nR = [[1]]\nP0 = [[1]]\n"
    "[filter]\nQ = [[0.3]]\nR = [[0.78]]\n[study]\nruns = 50\nsteps = 300\n";

TEST_F(TuneLogs, OfALogSaysWhatInnovationsAloneCanTell) {
  write("level.toml", kLocalLevel);
  ASSERT_EQ(run({"run", "level.toml", "--runs", "20", "--log", "logs", "--quiet"}).code, 0);
  const Json j = json({"tune", "logs", "--format", "json"});
  EXPECT_EQ(j["parameters"][0]["name"], "factor on S");
  EXPECT_NEAR(j["parameters"][0]["value"].get<double>(), 1.0, 0.15);
  EXPECT_EQ(j["sensors"][0]["gain"], "too large") << "Q is three times too large";
  EXPECT_EQ(j["sensors"][0]["values"], 6000);
  EXPECT_NE(j["notes"][0].get<std::string>().find("cannot be separated"), std::string::npos);
  EXPECT_EQ(run({"tune", "logs", "--write", "tuned.toml"}).code, 2);
  ASSERT_EQ(run({"tune", "logs", "--out", "page", "--quiet"}).code, 0);
  EXPECT_NE(read("page/index.html").find("S agrees with its innovations"), std::string::npos);
}

TEST_F(TuneLogs, WithoutInnovationsThereIsNothingToTune) {
  write("errors.csv", "error.x,P.1.1\n0.5,1\n-0.5,1\n");
  const Finished f = run({"tune", "errors.csv"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err,
            "credence: errors.csv: no innovations with their covariance, which are what a log is tuned by; "
            "check judges errors\n");
  write("more.csv", "error.x,P.1.1\n0.5,1\n-0.5,1\n");
  EXPECT_NE(run({"tune", "errors.csv", "more.csv"}).err.find("errors.csv and 1 more: no innovations"),
            std::string::npos);
}

/// White innovations of these standard deviations, a thousand of each in turn, where S says 1.
std::string log_of(const std::vector<double>& deviations) {
  std::string text = "innovation.1,S.1.1\n";
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const double deviation : deviations) {
    for (int i = 0; i < 1000; ++i) text += std::to_string(deviation * normal(random)) + ",1\n";
  }
  return text;
}

// Of a variance of 4, whose estimate has a relative standard error of √(2/4000).
TEST_F(TuneLogs, TheFactorOnSIsTheVarianceOfTheInnovations) {
  write("steady.csv", log_of({2.0, 2.0, 2.0, 2.0}));
  const Json j = json({"tune", "steady.csv", "--fail-on-inconsistent", "--format", "json"});
  EXPECT_EQ(j["parameters"][0]["name"], "factor on S");
  EXPECT_NEAR(j["parameters"][0]["value"].get<double>(), 4.0, 5.0 * 4.0 * std::sqrt(2.0 / 4000.0));
}

TEST_F(TuneLogs, AFactorThatIsRightForNoPartOfTheLogIsInconsistent) {
  write("changes.csv", log_of({1.0, 1.0, 1.0, 3.0}));
  EXPECT_EQ(run({"tune", "changes.csv", "--fail-on-inconsistent"}).code, 1);
  EXPECT_EQ(run({"tune", "changes.csv"}).code, 0);
}

}  // namespace
}  // namespace credence::internal
