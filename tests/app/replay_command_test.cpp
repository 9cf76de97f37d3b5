// `credence replay` as a user types it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class ReplayCommand : public CommandTest {
 protected:
  Finished replay(std::vector<std::string> arguments, const fs::path& data) const {
    arguments.insert(arguments.begin(), {"replay"});
    arguments.insert(arguments.end(), {"--data", fs::absolute(data).string()});
    return run(arguments);
  }
  Json document(std::vector<std::string> arguments, const fs::path& data) const {
    arguments.insert(arguments.end(), {"--format", "json"});
    const Finished f = replay(std::move(arguments), data);
    EXPECT_EQ(f.code, 0) << f.err;
    return Json::parse(f.out);
  }
};

bool contains(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

/// Ended as bad input with one line that says these words, and nothing else.
void expect_one_error(const Finished& f, const std::vector<std::string>& words) {
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.out, "");
  for (const std::string& word : words) EXPECT_TRUE(contains(f.err, word)) << f.err;
  EXPECT_EQ(std::ranges::count(f.err, '\n'), 1) << f.err;
}

TEST_F(ReplayCommand, SaysWhatIsMissing) {
  expect_one_error(run({"replay", "carpark"}), {"--data", "CREDENCE_DATA"});
  const TemporaryFolder empty;
  expect_one_error(replay({"carpark"}, empty.path()), {"data_set.mat"});
  expect_one_error(replay({"mrclam"}, empty.path()), {"Barcodes.dat"});
  EXPECT_EQ(replay({"mrclam", "--variants"}, empty.path()).code, 2);
  EXPECT_EQ(replay({"mrclam", "--robot", "6"}, empty.path()).code, 2);
}

TEST_F(ReplayCommand, CarparkGivesTheKeysOfTheContract) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const Json j = document({"carpark"}, data);
  EXPECT_EQ(j["dataset"], "carpark");
  EXPECT_EQ(j["observations"], 888);
  EXPECT_EQ(j["scans_with_observations"], 505);
  EXPECT_EQ(j["associated"], 888);
  EXPECT_EQ(j["rejected"], 0);
  EXPECT_NEAR(j["nis"]["mean"].get<double>(), 0.135, 0.005);
  EXPECT_EQ(j["nis"]["expected"], 2.0);
  EXPECT_EQ(j["gps_nees"]["expected"], 2.0);
  EXPECT_NEAR(j["landmark_rms_aligned"].get<double>(), 0.0475, 0.001);
  for (const char* key : {"vehicle_rmse", "landmark_rms", "landmark_nees", "covariance", "settings"})
    EXPECT_TRUE(j.contains(key)) << key;
  for (const char* key : {"vehicle_max", "vehicle_final", "landmarks_max", "landmarks_final"})
    EXPECT_TRUE(j["covariance"].contains(key)) << key;
  EXPECT_EQ(j["judgement"]["verdict"], "pessimistic");
  EXPECT_EQ(j["judgement"]["nees"]["verdict"], "undecided");
  EXPECT_EQ(j["judgement"]["nees"]["values"], 626);
  EXPECT_EQ(j["judgement"]["innovations"]["nis"]["verdict"], "pessimistic");
  EXPECT_EQ(j["judgement"]["innovations"]["nis"]["values"], 873);
  EXPECT_EQ(j["judgement"]["maps"][0]["shape"]["dof"], 27);
}

// Multiplying P0, Q and R by the noise scale makes the mean NIS the expected one: gain and path stay.
TEST_F(ReplayCommand, TheNoiseScaleMakesTheInnovationsConsistentInTheMean) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const Json before = document({"carpark"}, data);
  const double s = std::sqrt(before["judgement"]["innovations"]["noise_scale"]["value"].get<double>());
  std::vector<std::string> scaled = {"carpark"};
  for (const auto& [key, value] :
       {std::pair{"noise.speed_std", 0.7}, std::pair{"noise.steering_std_deg", 7.0},
        std::pair{"noise.range_std", 0.1}, std::pair{"noise.bearing_std_deg", 1.0},
        std::pair{"initial.position_std", 0.05}, std::pair{"initial.heading_std_deg", 2.0}})
    scaled.insert(scaled.end(), {"--set", std::string(key) + "=" + std::to_string(s * value)});
  const Json after = document(scaled, data);
  EXPECT_NEAR(after["judgement"]["innovations"]["nis"]["mean"].get<double>(), 2.0, 1e-3);
  EXPECT_NEAR(after["vehicle_rmse"].get<double>(), before["vehicle_rmse"].get<double>(), 1e-3);
}

TEST_F(ReplayCommand, RobotsAreRunsOfOneVerdict) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const Json j = document({"mrclam", "--robot", "1,3"}, data);
  ASSERT_EQ(j["runs"].size(), 2U);
  EXPECT_EQ(j["runs"][0]["run"], "robot 1");
  EXPECT_EQ(j["runs"][1]["pose_nees"]["expected"], 3.0);
  EXPECT_LT(j["runs"][1]["jacobians_at_truth"]["pose_nees"]["mean"], 5.0);
  EXPECT_EQ(j["judgement"]["nees"]["verdict"], "optimistic");
  EXPECT_EQ(j["judgement"]["maps"].size(), 2U);
  const std::string text = replay({"mrclam", "--robot", "1,3"}, data).out;
  EXPECT_TRUE(contains(text, "mrclam, robot 3") && contains(text, "2 runs")) << text;
}

TEST_F(ReplayCommand, ABrokenFileIsOneErrorWithItsPlace) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const TemporaryFolder broken;
  testing::copy_data(data, broken);
  std::ofstream(broken / "Robot3_Odometry.dat", std::ios::app) << "1248446000.0 0.1 0.0\n";
  expect_one_error(replay({"mrclam", "--robot", "3"}, broken.path()), {"Robot3_Odometry.dat:", "backwards"});
}

}  // namespace
}  // namespace credence::internal
