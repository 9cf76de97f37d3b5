#include "datasets/replay/mrclam_checks.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

/// A robot on a circle of radius 2 m about the origin at 0.2 m/s for two minutes, which sees two landmarks.
MrclamLog circling_robot() {
  MrclamLog log;
  log.landmarks = {{.subject = 6, .position_m = {0, 0}}, {.subject = 7, .position_m = {5, 1}}};
  for (int k = 0; k <= 1200; ++k) {
    const double t = 100.0 + 0.1 * k, angle = 0.1 * (t - 100.0);
    const Eigen::Vector3d pose(2.0 * std::cos(angle), 2.0 * std::sin(angle),
                               wrap_angle(angle + 0.5 * std::numbers::pi));
    log.truth.push_back({t, pose});
    log.odometry.push_back({t, 0.2, 0.1});
    if (k % 10 != 0) continue;
    for (std::size_t i = 0; i < 2; ++i) {
      const Eigen::Vector2d to = log.landmarks[i].position_m - pose.head<2>();
      log.measurements.push_back({t, i, to.norm(), wrap_angle(std::atan2(to.y(), to.x()) - pose(2))});
    }
  }
  return log;
}

TEST(MrclamChecks, a_log_that_fits_itself_has_no_contradiction) {
  const MrclamLog log = circling_robot();
  EXPECT_EQ(truth_contradiction(log), "");
  EXPECT_EQ(odometry_contradiction(log), "");
  EXPECT_EQ(measurement_contradiction(log), "");
}

TEST(MrclamChecks, a_robot_may_drive_backwards) {
  MrclamLog log = circling_robot();
  for (MrclamPose& pose : log.truth) pose.pose(2) = wrap_angle(pose.pose(2) + std::numbers::pi);
  for (MrclamOdometry& sample : log.odometry) sample.speed_mps *= -1.0;
  EXPECT_EQ(truth_contradiction(log), "");
  EXPECT_EQ(odometry_contradiction(log), "");
}

TEST(MrclamChecks, a_truth_that_goes_where_it_does_not_head_is_contradicted) {
  MrclamLog log = circling_robot();
  for (MrclamPose& pose : log.truth) std::swap(pose.pose(0), pose.pose(1));
  EXPECT_THAT(truth_contradiction(log), HasSubstr("the path of 24.0 m goes only"));
  log = circling_robot();
  for (MrclamPose& pose : log.truth) pose.pose(2) = wrap_angle(pose.pose(2) + 0.5 * std::numbers::pi);
  EXPECT_THAT(truth_contradiction(log), HasSubstr("m where the robot heads: swapped columns?"));
}

TEST(MrclamChecks, the_jitter_of_a_standing_robot_is_no_path) {
  MrclamLog log = circling_robot();
  for (std::size_t k = 0; k < log.truth.size(); ++k) {
    log.truth[k].pose = Eigen::Vector3d(k % 2 == 0 ? 0.009 : -0.009, 0.0, 1.5);
    log.odometry[k].speed_mps = 0.0;
  }
  EXPECT_EQ(truth_contradiction(log), "");
  EXPECT_EQ(odometry_contradiction(log), "");
}

TEST(MrclamChecks, odometry_that_goes_another_way_than_the_truth_is_contradicted) {
  MrclamLog fast = circling_robot(), slow = circling_robot(), later = circling_robot(),
            factor = circling_robot();
  for (MrclamOdometry& sample : fast.odometry) sample.speed_mps *= 2.1;
  for (MrclamOdometry& sample : slow.odometry) sample.speed_mps *= 0.45;
  for (MrclamOdometry& sample : factor.odometry) sample.speed_mps *= 1.9;
  for (MrclamOdometry& sample : later.odometry) sample.time_s += 121.0;
  EXPECT_THAT(odometry_contradiction(fast), HasSubstr("50.4 m driven where the truth goes 24.0 m"));
  EXPECT_THAT(odometry_contradiction(slow), HasSubstr("10.8 m driven where the truth goes 24.0 m"));
  EXPECT_EQ(odometry_contradiction(factor), "");
  EXPECT_THAT(odometry_contradiction(later), HasSubstr("have nothing in common"));
  for (MrclamOdometry& sample : later.odometry) sample.time_s -= 242.0;
  EXPECT_THAT(odometry_contradiction(later), HasSubstr("have nothing in common"));
}

TEST(MrclamChecks, half_of_the_observations_must_fit_in_range_and_bearing) {
  const MrclamLog good = circling_robot();
  const auto spoiled = [&](std::size_t share, double range_m, double bearing_rad) {
    MrclamLog log = good;
    for (std::size_t i = 0; i < log.measurements.size(); ++i) {
      if (i % 100 >= share) continue;
      log.measurements[i].range_m += range_m;
      log.measurements[i].bearing_rad += bearing_rad;
    }
    return measurement_contradiction(log);
  };
  EXPECT_EQ(spoiled(40, 0.6, 0.0), "");
  EXPECT_THAT(spoiled(60, 0.6, 0.0),
              HasSubstr("of 242 observations fit the truth and the survey: swapped columns"));
  EXPECT_THAT(spoiled(60, 0.0, 11.0 * kRadiansPerDegree), HasSubstr("observations fit"));
  EXPECT_EQ(spoiled(100, 0.4, 9.0 * kRadiansPerDegree), "");
  EXPECT_EQ(spoiled(100, 0.0, 2.0 * std::numbers::pi), "") << "whole turns are none";
  MrclamLog late = good;
  for (MrclamMeasurement& seen : late.measurements) seen.time_s += 1e3;
  EXPECT_EQ(measurement_contradiction(late),
            "no measurement of a landmark lies within the time of the truth");
}

}  // namespace
}  // namespace credence::internal
