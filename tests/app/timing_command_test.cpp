#include "tests/app/command.h"

namespace credence::internal {
namespace {

class TimingCommandTest : public CommandTest {};

TEST_F(TimingCommandTest, TellsStepsSlopesAndRates) {
  const Json j = json({"timing", "--landmarks", "10,20", "--observed", "1", "--repetitions", "2", "--out",
                       "t", "--format", "json", "--quiet"});
  ASSERT_EQ(j["rows"].size(), 8U);
  for (const Json& row : j["rows"]) EXPECT_GT(row["seconds_per_step"].get<double>(), 0.0);
  EXPECT_EQ(j["rows"][0]["filter"], "full");
  // Too few sizes for a slope: null with a reason, never a made-up number.
  EXPECT_TRUE(j["slopes"]["map"]["value"].is_null());
  EXPECT_FALSE(j["slopes"]["map"]["reason"].empty());
  EXPECT_GT(j["monte_carlo"]["steps_per_second"].get<double>(), 0.0);
  EXPECT_GT(j["monte_carlo"]["reference_steps_per_second"].get<double>(), 0.0);
  EXPECT_FALSE(j["machine"]["processor"].empty());
  EXPECT_EQ(Json::parse(read("t/timing.json")), j);
  EXPECT_NE(read("t/index.html").find("<svg"), std::string::npos);
}

TEST_F(TimingCommandTest, RefusesWhatCannotBeTimed) {
  EXPECT_EQ(run({"timing", "--landmarks", "0"}).code, 2);
  EXPECT_EQ(run({"timing", "--landmarks", "5", "--observed", "10"}).code, 2);
  EXPECT_EQ(run({"timing", "--repetitions", "0"}).code, 2);
}

}  // namespace
}  // namespace credence::internal
