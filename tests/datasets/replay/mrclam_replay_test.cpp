#include "datasets/replay/mrclam_replay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/filters/estimators/estimators.h"
#include "core/manifold/angle.h"
#include "core/models/range_bearing.h"
#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

/// A robot that circles among three landmarks without any noise, 20 s at 10 Hz, looking twice a second.
MrclamLog perfect_log() {
  MrclamLog log;
  log.robot = 2;
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(3, 0), Eigen::Vector2d(-2, 2), Eigen::Vector2d(0, -3)})
    log.landmarks.push_back({6 + static_cast<int>(log.landmarks.size()), place});
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
  result.sensor = {};
  result.noise.range_std = 0.067;
  result.noise.bearing_std_deg = 1.05;
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

/// The perfect log as a camera and a miscalibrated odometry would have written it; landmarks ahead only.
MrclamLog log_of_flawed_sensors() {
  MrclamLog log = perfect_log();
  std::erase_if(log.measurements, [](const MrclamMeasurement& m) { return std::abs(m.bearing_rad) > 1; });
  for (MrclamMeasurement& m : log.measurements) m.range_m = 0.05 + 1.02 * m.range_m * std::cos(m.bearing_rad);
  for (MrclamOdometry& sample : log.odometry) {
    sample.speed_mps /= 0.9;
    sample.turn_rate_rps = (sample.turn_rate_rps + 0.01) / 0.95;
  }
  return log;
}

TEST(MrclamReplay, SystematicErrorsOfTheSensorsAreUndone) {
  ReplaySettings informed = settings(), ignorant = settings();
  informed.sensor = {.range = RangeKind::depth,
                     .range_offset_m = 0.05,
                     .range_scale = 1.02,
                     .speed_scale = 0.9,
                     .turn_scale = 0.95,
                     .turn_drift_deg_s = -0.01 / kRadiansPerDegree};
  const MrclamLog log = log_of_flawed_sensors();
  const ReplayResult result = replay_mrclam(log, informed);
  EXPECT_GT(result.updated, 20);
  EXPECT_LT(result.vehicle_rmse, 1e-5);
  EXPECT_LT(result.landmark_rms, 1e-5);
  EXPECT_GT(replay_mrclam(log, ignorant).landmark_rms, 0.05);
}

TEST(MrclamReplay, NoDepthBesideTheCamera) {
  ReplaySettings depth = settings();
  depth.sensor.range = RangeKind::depth;
  EXPECT_THROW(replay_mrclam(perfect_log(), depth), std::invalid_argument);
}

TEST(MrclamReplay, WithoutErrorsJacobiansAtTheTruthAreThoseAtTheEstimate) {
  ReplaySettings at_truth = settings();
  at_truth.filter.jacobians = ReplayJacobians::truth;
  for (const Index anchors : {0, 1}) {
    ReplaySettings plain = settings();
    plain.world.full = at_truth.world.full = anchors > 0;
    const ReplayResult a = replay_mrclam(perfect_log(), plain), b = replay_mrclam(perfect_log(), at_truth);
    EXPECT_EQ(b.updated, a.updated);
    EXPECT_TRUE(b.map_covariance.isApprox(a.map_covariance, 1e-4));
  }
}

// Without errors every estimator stays at the truth, with observations judged by its own innovation.
TEST(MrclamReplay, EveryEstimatorStaysAtTheTruthWithoutErrors) {
  const ReplayResult plain = replay_mrclam(perfect_log(), settings());
  for (const EstimatorKind& kind : estimator_kinds()) {
    ReplaySettings s = settings();
    s.filter.gate = 0.999;
    s.filter.estimator = kind.name;
    const ReplayResult result = replay_mrclam(perfect_log(), s);
    EXPECT_EQ(result.updated, plain.updated) << kind.name;
    EXPECT_EQ(result.rejected, 0) << kind.name;
    EXPECT_LT(result.landmark_rms, plain.landmark_rms + 1e-3) << kind.name;
    EXPECT_LT(result.vehicle_rmse, plain.vehicle_rmse + 1e-3) << kind.name;
  }
}

TEST(MrclamReplay, WhitenedObservationsOfABatchAddUpToItsNis) {
  MrclamLog log = perfect_log();
  for (std::size_t i = 0; i < log.measurements.size(); ++i)
    log.measurements[i].range_m += 0.03 * std::sin(1.7 * static_cast<double>(i));
  const ReplayResult result = replay_mrclam(log, settings());
  double of_observations = 0, of_updates = 0;
  for (const ReplayObservation& observation : result.records) {
    of_observations += observation.whitened.squaredNorm();
    if (observation.first_of_batch) {
      EXPECT_NEAR(observation.whitened.squaredNorm(), observation.nis, 1e-9);
    }
  }
  for (const ReplayUpdate& update : result.updates) of_updates += update.nis;
  EXPECT_GT(of_observations, 0.1);
  EXPECT_NEAR(of_observations, of_updates, 1e-9 * of_updates);
}

// The real logs: everything is accounted for. What the file calls range is the depth along the axis of the
// camera: taken for a distance, it makes most of the "gross range errors" and doubles the error of the map.
TEST(MrclamReplay, RangesOfTheRealLogsAreDepths) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  for (const int robot : {1, 3}) {
    const MrclamLog log = read_mrclam(data, robot);
    const ReplayResult result = replay_mrclam(log, mrclam_settings(robot));
    EXPECT_EQ(result.observations + result.rows_before_start, static_cast<Index>(log.measurements.size()));
    EXPECT_EQ(result.updated + result.initialised + result.rejected, result.observations);
    EXPECT_EQ(result.initialised, 15);
    EXPECT_LT(result.rejected, robot == 1 ? 20 : 60);
    EXPECT_EQ(static_cast<Index>(result.references.size()) + result.times_without_truth,
              result.scans_with_observations);
    EXPECT_GT(result.duration_s, 880);
    EXPECT_LT(result.landmark_rms_aligned, 0.05);
    EXPECT_NEAR(result.nis.expected, 1.986, 1e-3);

    ReplaySettings distance = mrclam_settings(robot);
    distance.sensor.range = RangeKind::distance;
    const ReplayResult wrong = replay_mrclam(log, distance);
    EXPECT_GT(wrong.rejected, 5 * result.rejected);
    EXPECT_GT(wrong.landmark_rms_aligned, 1.5 * result.landmark_rms_aligned);
  }
}

/// The filter's standard deviation of the heading at the last reference before a time.
double heading_std_deg(const ReplayResult& result, double time_s) {
  double variance = 0;
  for (const ReplayReference& reference : result.references)
    if (reference.time_s <= time_s) variance = reference.covariance(2, 2);
  return std::sqrt(variance) / kRadiansPerDegree;
}

// Robot 1 sees nothing for 39 s. The next observations, for 27 s, are of landmarks never seen before, which
// can tell nothing of its heading; yet the EKF becomes sure of it. With Jacobians at the truth it does not.
TEST(MrclamReplay, TheEkfGainsAHeadingFromLandmarksThatItPlacedItself) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const MrclamLog log = read_mrclam(data, 1);
  ReplaySettings at_truth = mrclam_settings(1);
  at_truth.filter.jacobians = ReplayJacobians::truth;
  const ReplayResult ekf = replay_mrclam(log, mrclam_settings(1)), ideal = replay_mrclam(log, at_truth);
  for (const ReplayResult* result : {&ekf, &ideal}) EXPECT_GT(heading_std_deg(*result, 49.1), 16);
  EXPECT_LT(heading_std_deg(ekf, 56), 8);
  EXPECT_GT(heading_std_deg(ideal, 56), 16);
}

// Robot 3 stays near the truth, so that Jacobians there are those of a filter without spurious information:
// its NEES is nearly what it must be, while that of the EKF is far above.
TEST(MrclamReplay, JacobiansAtTheTruthMakeTheNeesNearlyConsistent) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const MrclamLog log = read_mrclam(data, 3);
  ReplaySettings at_truth = mrclam_settings(3);
  at_truth.filter.jacobians = ReplayJacobians::truth;
  const ReplayResult ekf = replay_mrclam(log, mrclam_settings(3)), ideal = replay_mrclam(log, at_truth);
  EXPECT_GT(ekf.vehicle_nees.mean(), 20);
  EXPECT_LT(ideal.vehicle_nees.mean(), 5);
  EXPECT_LT(ideal.landmark_nees.mean(), 3);
  EXPECT_NEAR(ekf.nis.mean(), ideal.nis.mean(), 0.02) << "innovations do not see it";
}

// The same filter twice: the EKF with Jacobians at the truth, and the estimator of that name. They differ in
// where the measurement of a new landmark is linearised, at its reading or at the truth.
TEST(MrclamReplay, TheIdealEstimatorIsTheEkfWithJacobiansAtTheTruth) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  const MrclamLog log = read_mrclam(data, 3);
  ReplaySettings at_truth = mrclam_settings(3), named = at_truth;
  at_truth.filter.jacobians = ReplayJacobians::truth;
  named.filter.estimator = "ideal";
  const ReplayResult a = replay_mrclam(log, at_truth), b = replay_mrclam(log, named);
  EXPECT_EQ(b.observations, a.observations);
  EXPECT_NEAR(static_cast<double>(b.updated), static_cast<double>(a.updated), 5);
  EXPECT_NEAR(b.vehicle_nees.mean(), a.vehicle_nees.mean(), 0.1 * a.vehicle_nees.mean());
  // What the truth gives, estimators that know nothing of it give as well; sigma points do not.
  for (const char* estimator : {"fej", "oc"}) {
    named.filter.estimator = estimator;
    EXPECT_LT(replay_mrclam(log, named).vehicle_nees.mean(), 5.0) << estimator;
  }
  named.filter.estimator = "ukf";
  EXPECT_GT(replay_mrclam(log, named).vehicle_nees.mean(), 20.0);
  EXPECT_NEAR(b.heading_rmse_deg, a.heading_rmse_deg, 0.2 * a.heading_rmse_deg);
}

}  // namespace
}  // namespace credence::internal
