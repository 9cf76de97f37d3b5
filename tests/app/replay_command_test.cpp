// `credence replay` as a user types it.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "tests/datasets/data_folder.h"

namespace credence {
namespace {

using testing::TemporaryFolder;

struct ReplayCall {
  int code = -1;
  std::string text;  ///< stdout and stderr
};

ReplayCall call_replay(const std::string& arguments) {
  ReplayCall call;
  FILE* pipe = popen(
      (std::string("env -u CREDENCE_DATA ") + CREDENCE_BINARY + " replay " + arguments + " 2>&1").c_str(),
      "r");
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) call.text += buffer;
  const int status = pclose(pipe);
  call.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return call;
}

bool says(const ReplayCall& call, const std::string& words) {
  return call.text.find(words) != std::string::npos;
}

TEST(ReplayCommand, SaysWhatIsMissing) {
  const ReplayCall nowhere = call_replay("carpark");
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_TRUE(says(nowhere, "--data")) << nowhere.text;
  const TemporaryFolder empty;
  for (const char* dataset : {"carpark", "mrclam"}) {
    const ReplayCall call = call_replay(std::string(dataset) + " --data " + empty.path().string());
    EXPECT_EQ(call.code, 2);
    EXPECT_TRUE(says(call, dataset == std::string("carpark") ? "data_set.mat" : "Barcodes.dat")) << call.text;
    EXPECT_EQ(std::count(call.text.begin(), call.text.end(), '\n'), 1) << "one clear error";
  }
  EXPECT_EQ(call_replay("mrclam --variants --data " + empty.path().string()).code, 2);
  EXPECT_EQ(call_replay("mrclam --robot 6 --data " + empty.path().string()).code, 2);
}

TEST(ReplayCommand, CarparkGivesTheKeysOfTheContract) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const ReplayCall call = call_replay("carpark --format json --data " + data.string());
  ASSERT_EQ(call.code, 0) << call.text;
  const nlohmann::json j = nlohmann::json::parse(call.text);
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
  EXPECT_EQ(j["judgement"]["innovations"]["nis"]["verdict"], "pessimistic");
  EXPECT_EQ(j["judgement"]["maps"][0]["shape"]["dof"], 27);
}

// Multiplying P0, Q and R by the noise scale makes the mean NIS the expected one: gain and path stay.
TEST(ReplayCommand, TheNoiseScaleMakesTheInnovationsConsistentInTheMean) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const std::string base = "carpark --format json --data " + data.string();
  const nlohmann::json before = nlohmann::json::parse(call_replay(base).text);
  const double s = std::sqrt(before["judgement"]["innovations"]["noise_scale"]["value"].get<double>());
  std::string set;
  for (const auto& [key, value] :
       {std::pair{"noise.speed_std", 0.7}, std::pair{"noise.steering_std_deg", 7.0},
        std::pair{"noise.range_std", 0.1}, std::pair{"noise.bearing_std_deg", 1.0},
        std::pair{"initial.position_std", 0.05}, std::pair{"initial.heading_std_deg", 2.0}})
    set += std::string(" --set ") + key + "=" + std::to_string(s * value);
  const nlohmann::json after = nlohmann::json::parse(call_replay(base + set).text);
  EXPECT_NEAR(after["judgement"]["innovations"]["nis"]["mean"].get<double>(), 2.0, 1e-3);
  EXPECT_NEAR(after["vehicle_rmse"].get<double>(), before["vehicle_rmse"].get<double>(), 1e-3);
}

TEST(ReplayCommand, RobotsAreRunsOfOneVerdict) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const ReplayCall call = call_replay("mrclam --robot 1,3 --format json --data " + data.string());
  ASSERT_EQ(call.code, 0) << call.text;
  const nlohmann::json j = nlohmann::json::parse(call.text);
  ASSERT_EQ(j["runs"].size(), 2U);
  EXPECT_EQ(j["runs"][0]["run"], "robot 1");
  EXPECT_EQ(j["runs"][1]["pose_nees"]["expected"], 3.0);
  EXPECT_LT(j["runs"][1]["jacobians_at_truth"]["pose_nees"]["mean"], 5.0);
  EXPECT_EQ(j["judgement"]["nees"]["verdict"], "optimistic");
  EXPECT_EQ(j["judgement"]["maps"].size(), 2U);
  const ReplayCall text = call_replay("mrclam --robot 1,3 --data " + data.string());
  EXPECT_TRUE(says(text, "mrclam, robot 3") && says(text, "2 runs")) << text.text;
}

TEST(ReplayCommand, ABrokenFileIsOneErrorWithItsPlace) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const TemporaryFolder folder;
  folder.fill_from(data);
  std::ofstream(folder.path() / "Robot3_Odometry.dat", std::ios::app) << "1248446000.0 0.1 0.0\n";
  const ReplayCall call = call_replay("mrclam --robot 3 --data " + folder.path().string());
  EXPECT_EQ(call.code, 2);
  EXPECT_TRUE(says(call, "Robot3_Odometry.dat:") && says(call, "backwards")) << call.text;
  EXPECT_EQ(std::count(call.text.begin(), call.text.end(), '\n'), 1);
}

}  // namespace
}  // namespace credence
