#include "datasets/mrclam_replay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/range_bearing.h"
#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence {
namespace {

/// A robot that circles among three landmarks without any noise, 20 s at 10 Hz, looking twice a second.
MrclamLog perfect_log() {
  MrclamLog log;
  log.robot = 2;
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(3, 0), Eigen::Vector2d(-2, 2), Eigen::Vector2d(0, -3)})
    log.landmarks.push_back({6 + static_cast<int>(log.landmarks.size()), 0, place, {0, 0}});
  const Vehicle unicycle{VehicleKind::unicycle, {}};
  Pose pose(0.5, 0, 0.3);
  for (int k = 0; k <= 200; ++k) {
    const double time_s = 1e9 + 0.1 * k;
    const Control control(0.2, 0.3 + 0.2 * std::sin(0.2 * k));
    log.truth.push_back({time_s, pose});
    log.odometry.push_back({time_s, control(0), control(1)});
    if (k % 5 == 0)
      for (std::size_t i = 0; i < log.landmarks.size(); ++i) {
        const RangeBearing z = measure_range_bearing(pose, log.landmarks[i].position_m);
        log.measurements.push_back({time_s, i, z(0), z(1)});
      }
    // The replay predicts in five steps of 20 ms, so the truth is made of the same.
    for (int part = 0; part < 5; ++part) pose = unicycle.moved(pose, control, 0.02);
  }
  return log;
}

ReplaySettings settings() {
  ReplaySettings result = mrclam_settings(2);
  result.sensor.odometry_delay_s = 0;
  return result;
}

TEST(MrclamReplay, FollowsAPerfectLogExactly) {
  const ReplayResult result = replay_mrclam(perfect_log(), settings());
  EXPECT_EQ(result.observations, 123);
  EXPECT_EQ(result.scans_with_observations, 41);
  EXPECT_EQ(result.initialised, 3);
  EXPECT_EQ(result.updated, 120);
  EXPECT_EQ(result.references.size(), 41U);
  EXPECT_EQ(result.vehicle_nees.expected, 3);
  // Unix seconds have a resolution of 1e-7 s, and the robot drives 0.2 m/s.
  EXPECT_LT(result.vehicle_rmse, 1e-5);
  EXPECT_LT(result.landmark_rms, 1e-5);
  EXPECT_LT(result.nis.mean(), 1e-5);
  EXPECT_NEAR(result.duration_s, 20, 1e-6);
}

TEST(MrclamReplay, ADelayIsUndone) {
  MrclamLog log = perfect_log();
  for (MrclamOdometry& sample : log.odometry) sample.time_s -= 0.2;
  ReplaySettings ignorant = settings(), informed = settings();
  informed.sensor.odometry_delay_s = 0.2;
  EXPECT_GT(replay_mrclam(log, ignorant).vehicle_rmse, 1e-3);
  EXPECT_LT(replay_mrclam(log, informed).vehicle_rmse, 1e-5);
}

TEST(MrclamReplay, CountsWhatItCannotUse) {
  MrclamLog log = perfect_log();
  log.measurements.insert(log.measurements.begin(), {1e9 - 1, 0, 3, 0});
  log.truth.erase(log.truth.begin() + 100, log.truth.begin() + 120);  // lost for 2 s
  log.rows_of_robots = 4;
  log.rows_of_unknown_barcodes = 5;
  const ReplayResult result = replay_mrclam(log, settings());
  EXPECT_EQ(result.rows_before_start, 1);
  EXPECT_EQ(result.observations, 123);
  EXPECT_EQ(result.times_without_truth, 4);
  EXPECT_EQ(result.references.size(), 37U);
  EXPECT_EQ(result.rows_of_robots, 4);
  EXPECT_EQ(result.rows_of_unknown_barcodes, 5);
}

/// Without landmarks from second 5 on, and without odometry between seconds 5 and `until`.
MrclamLog log_with_gap(int until) {
  MrclamLog log = perfect_log();
  log.odometry.erase(log.odometry.begin() + 51, log.odometry.begin() + 10 * until);
  log.measurements.erase(log.measurements.begin() + 33, log.measurements.begin() + 6 * until);
  return log;
}

double distance_driven(const ReplayResult& result, double from_s, double to_s) {
  Point from = Point::Zero(), to = Point::Zero();
  for (const ReplayReference& reference : result.references) {
    if (reference.time_s <= from_s + 1e-6) from = reference.estimate.head<2>();
    if (reference.time_s <= to_s + 1e-6) to = reference.estimate.head<2>();
  }
  return (to - from).norm();
}

TEST(MrclamReplay, HoldsTheOdometryAcrossAGapButNotForEver) {
  EXPECT_NEAR(distance_driven(replay_mrclam(log_with_gap(6), settings()), 5, 6), 0.2, 0.01);
  MrclamLog broken = log_with_gap(15);
  for (MrclamMeasurement& seen : broken.measurements)
    if (seen.time_s > 1e9 + 14) seen.range_m += 50;  // gated: the pose is what the odometry says
  EXPECT_NEAR(distance_driven(replay_mrclam(broken, settings()), 5, 15), 0.2 * kMrclamMaxHoldS, 0.02);
}

TEST(MrclamReplay, NeedsATruthToStartFrom) {
  MrclamLog log = perfect_log();
  log.odometry.resize(50);
  log.truth.erase(log.truth.begin(), log.truth.begin() + 60);
  EXPECT_THROW(replay_mrclam(log, settings()), DataError);
}

TEST(MrclamReplay, GrossErrorsAreGatedAndCounted) {
  MrclamLog log = perfect_log();
  for (std::size_t i = 30; i < log.measurements.size(); i += 10) log.measurements[i].range_m += 1.5;
  const ReplayResult result = replay_mrclam(log, settings());
  EXPECT_EQ(result.rejected, 10);
  EXPECT_LT(result.vehicle_rmse, 1e-4);
  ReplaySettings trusting = settings();
  trusting.filter.gate = 0;
  EXPECT_GT(replay_mrclam(log, trusting).vehicle_rmse, 0.01);
}

// The real logs: everything is accounted for, and the shape of the map is right to about a decimetre. The
// pose NEES is far above 3 for both robots: turning is known to ±2° a second only and the EKF does not see
// what a wrong heading does to its Jacobians. That is the finding, not a defect of the replay (it is 3 in the
// simulated world).
TEST(MrclamReplay, ReplaysTheRealLogs) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  for (const int robot : {1, 3}) {
    const MrclamLog log = read_mrclam(data, robot);
    const ReplayResult result = replay_mrclam(log, mrclam_settings(robot));
    EXPECT_EQ(result.observations + result.rows_before_start, static_cast<Index>(log.measurements.size()));
    EXPECT_EQ(result.updated + result.initialised + result.rejected, result.observations);
    EXPECT_EQ(result.initialised, 15);
    EXPECT_LT(static_cast<double>(result.rejected), 0.2 * static_cast<double>(result.observations));
    EXPECT_EQ(static_cast<Index>(result.references.size()) + result.times_without_truth,
              result.scans_with_observations);
    EXPECT_GT(result.duration_s, 880);
    EXPECT_LT(result.landmark_rms_aligned, 0.12);
    EXPECT_GT(result.vehicle_nees.mean(), 3);
    EXPECT_NEAR(result.nis.expected, 1.986, 1e-3);
  }
}

}  // namespace
}  // namespace credence
