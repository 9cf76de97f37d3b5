#include "datasets/replay/replay_tuning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/manifold/angle.h"
#include "core/models/range_bearing.h"
#include "core/stop_point.h"
#include "datasets/replay/mrclam_replay.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

constexpr double kRangeStd = 0.05, kBearingStdDeg = 1.0, kSpeedStd = 0.3, kTurnStd = 0.5;

/// A robot that circles among five landmarks; the truth moves in the steps of the replay, 20 ms, each with
/// noise of its own.
MrclamLog noisy_log(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  MrclamLog log;
  log.robot = static_cast<int>(seed);
  for (int i = 0; i < 5; ++i) {
    const double angle = 1.2566 * i;
    log.landmarks.push_back({6 + i, {4.0 * std::cos(angle), 4.0 * std::sin(angle)}});
  }
  const Vehicle unicycle{VehicleKind::unicycle, {}};
  Pose pose(1.5, 0, 1.57);
  for (int k = 0; k <= 600; ++k) {
    const double time_s = 1e9 + 0.1 * k;
    const Control control(0.4, 0.27);
    log.truth.push_back({time_s, pose});
    log.odometry.push_back({time_s, control(0), control(1)});
    for (std::size_t i = 0; k % 5 == 0 && i < log.landmarks.size(); ++i) {
      const RangeBearing z = measure_range_bearing(pose, log.landmarks[i].position_m);
      log.measurements.push_back({time_s, i, z(0) + kRangeStd * normal(random),
                                  wrap_angle(z(1) + kBearingStdDeg * kRadiansPerDegree * normal(random))});
    }
    for (int part = 0; part < 5; ++part) {
      const Control moved = control + Control(kSpeedStd * normal(random), kTurnStd * normal(random));
      pose = unicycle.moved(pose, moved, 0.02);
    }
  }
  return log;
}

ReplaySettings wrong_settings() {
  ReplaySettings settings = mrclam_settings(2);
  settings.sensor = {};
  settings.filter.gate = 0.0;
  settings.noise = {.speed_std = 0.6,
                    .steering_std_deg = 0,
                    .turn_rate_std = 1.0,
                    .range_std = 0.15,
                    .bearing_std_deg = 0.5};
  return settings;
}

std::vector<ReplayedLog> noisy_logs(unsigned count) {
  std::vector<ReplayedLog> logs;
  for (unsigned i = 0; i < count; ++i) logs.push_back(replayed_log(noisy_log(i + 1), wrong_settings()));
  return logs;
}

TEST(ReplayTuning, FindsTheNoiseOfTheWorld) {
  const std::vector<ReplayedLog> logs = noisy_logs(3);
  const ReplayScore score(logs, replay_noise_keys(logs.front().settings));
  EXPECT_EQ(score.units(), 30);
  const ReplayTuning tuning = tune_replays(logs, score, 0.95);
  const std::vector<double> truth = {kSpeedStd, kTurnStd, kRangeStd, kBearingStdDeg};
  ASSERT_EQ(tuning.tuning.parameters.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const TunedParameter& p = tuning.tuning.parameters[i];
    ASSERT_TRUE(p.identifiable) << p.name << ": " << p.reason;
    const double deviation = std::log(p.upper / p.lower) / (2.0 * 1.96);
    EXPECT_LT(deviation, 0.15) << p.name;
    EXPECT_NEAR(std::log(p.value / truth[i]), 0.0, 5.0 * deviation) << p.name << " = " << p.value;
  }
  EXPECT_TRUE(tuning.parts_are_logs);
  ASSERT_EQ(tuning.left_out.size(), 3U);
  for (const LeftOutPart& part : tuning.left_out) {
    EXPECT_EQ(part.observations, 600);
    EXPECT_EQ(part.values.size(), 4U);
    EXPECT_GT(part.score_after, part.score_before);
    EXPECT_NEAR(part.nis_after, 2.0, 5.0 * 2.0 / std::sqrt(600.0)) << part.name;
  }
  EXPECT_TRUE(is_inconsistent(tuning.before.nis.verdict));
  EXPECT_EQ(tuning.after.nis.verdict, Verdict::consistent);
}

TEST(ReplayTuning, OfOneLogLeavesOutItsFifths) {
  const std::vector<ReplayedLog> logs = noisy_logs(1);
  const ReplayScore score(logs, {"noise.range_std", "noise.bearing_std_deg"});
  const ReplayTuning tuning = tune_replays(logs, score, 0.95);
  ASSERT_EQ(tuning.left_out.size(), 5U);
  Index observations = 0;
  for (const LeftOutPart& part : tuning.left_out) observations += part.observations;
  EXPECT_EQ(observations, 600);
  EXPECT_FALSE(tuning.parts_are_logs);
}

// Where their number is no multiple of 30, too, a fifth is six of the stretches that the others are tuned on.
TEST(ReplayTuning, AFifthLeftOutIsThatOfTheScore) {
  MrclamLog log = noisy_log(1);
  log.measurements.resize(log.measurements.size() - 7);
  const std::vector<ReplayedLog> logs{replayed_log(std::move(log), wrong_settings())};
  const ReplayScore score(logs, {"noise.range_std"});
  const Vector nis = score.scores(Vector::Zero(1), false).nis;
  const ReplayTuning tuning = tune_replays(logs, score, 0.95);
  ASSERT_EQ(tuning.left_out.size(), 5U);
  for (Index i = 0; i < 5; ++i) {
    const LeftOutPart& part = tuning.left_out[static_cast<std::size_t>(i)];
    const double sum = part.nis_before * static_cast<double>(part.observations);
    EXPECT_NEAR(sum, nis.segment(6 * i, 6).sum(), 1e-9 * sum) << part.name;
    EXPECT_TRUE(part.tuned_apart) << part.name;
  }
}

/// What is left out and what the score is of must not depend on the noise.
TEST(ReplayTuning, LeavesOutForGoodWhatTheGateRejects) {
  MrclamLog log = noisy_log(4);
  for (std::size_t i = 100; i < log.measurements.size(); i += 100) log.measurements[i].range_m += 3.0;
  ReplaySettings settings = wrong_settings();
  settings.filter.gate = 0.9999;
  const Index rejected = replay_mrclam(log, settings).rejected;
  EXPECT_GE(rejected, 6);
  const ReplayedLog replayed = replayed_log(log, settings);
  EXPECT_EQ(replayed.left_out, rejected);
  const ReplayResult result = replayed.replay(replayed.settings);
  EXPECT_EQ(result.rejected, 0);
  EXPECT_EQ(result.updated + result.initialised, 605 - rejected);
}

TEST(ReplayTuning, TheScoreIsThatOfTheBatches) {
  const std::vector<ReplayedLog> logs = noisy_logs(1);
  const ReplayScore score(logs, {"noise.range_std"});
  const UnitScores scores = score.scores(Vector::Zero(1), false);
  const ReplayResult result = logs.front().replay(logs.front().settings);
  double nis = 0.0;
  for (const ReplayUpdate& update : result.updates) nis += update.nis;
  EXPECT_NEAR(scores.nis.sum(), nis, 1e-9 * nis);
  EXPECT_EQ(scores.steps, 600.0);
  EXPECT_EQ(scores.dof, 1200.0);
}

TEST(ReplayTuning, RefusesWhatWouldChooseItsOwnData) {
  ReplaySettings settings = wrong_settings();
  settings.filter.gate = 0.99;
  settings.filter.association = ReplayAssociation::compatibility;
  EXPECT_THROW(replayed_log(noisy_log(1), settings), std::invalid_argument);
  ReplaySettings gated = carpark_settings();
  gated.filter.gate = 0.99;
  EXPECT_THROW(replayed_log(CarparkLog{}, gated), std::invalid_argument);
  std::vector<ReplayedLog> logs = noisy_logs(2);
  EXPECT_THROW(ReplayScore(logs, {"sensor.range_scale"}), std::invalid_argument);
  logs[1].settings.noise.range_std = 0.2;
  EXPECT_THROW(ReplayScore(logs, {"noise.range_std"}), std::invalid_argument) << "two beginnings";
  EXPECT_THROW(ReplayScore({}, {"noise.range_std"}), std::invalid_argument);
}

TEST(ReplayTuning, CanBeStopped) {
  const std::atomic<bool> stop = true;
  const std::vector<ReplayedLog> logs = noisy_logs(1);
  EXPECT_THROW(ReplayScore(logs, {"noise.range_std"}, 1, &stop).scores(Vector::Zero(1), false), Stopped);
}

/// The car park's own numbers: odometry and laser are several times better than ACFR's tuning, and no noise
/// makes all fifths of the drive right.
TEST(ReplayTuning, TheCarParkAsksForLessNoise) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const std::vector<ReplayedLog> logs{replayed_log(read_carpark(data), carpark_settings())};
  const ReplayScore score(logs, replay_noise_keys(logs.front().settings));
  const ReplayTuning tuning = tune_replays(logs, score, 0.95);
  EXPECT_TRUE(tuning.tuning.misspecified);
  EXPECT_NEAR(tuning.before.nis.mean, 0.135, 0.005);
  EXPECT_EQ(tuning.before.nis.verdict, Verdict::pessimistic);
  for (const TunedParameter& p : tuning.tuning.parameters) {
    EXPECT_TRUE(p.identifiable) << p.name;
    EXPECT_LT(p.upper, p.before) << p.name;
  }
  EXPECT_GT(tuning.tuning.score_after, tuning.tuning.score_before + 2.0);
  EXPECT_LT(tuning.after.adjusted_p_value[1], 1e-6) << "the law is not that of any noise";
}

}  // namespace
}  // namespace credence::internal
