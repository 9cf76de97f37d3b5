#include "datasets/logs/time_offset.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "core/manifold/sek3.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

constexpr double kBetween_s = 0.1;
constexpr PoseErrorAxes kRight{.position = PositionError::twist, .orientation = OrientationError::body};

SpatialPose course(double t) {
  const SE3 T(SO3::Exp(Eigen::Vector3d(0.3 * std::sin(0.4 * t), 0.2 * std::cos(0.5 * t), 0.3 * t)),
              Eigen::Vector3d(8.0 * std::cos(0.3 * t), 6.0 * std::sin(0.4 * t), std::sin(0.5 * t)));
  return {T.translation(), T.rotation().quaternion()};
}

struct OffsetLog {
  std::vector<EstimateSample> samples;
  Trajectory truth;
};

/// Estimates of the course at t + offset, stamped t, whose errors are `factor` times as large as P says and
/// correlated by `correlation` from row to row.
OffsetLog offset_log(std::uint64_t seed, int rows, double offset_s, double correlation, double factor = 1.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  OffsetLog log;
  PoseError sigma;
  sigma << 0.1, 0.05, 0.08, 0.02, 0.01, 0.03;
  PoseError white = PoseError::NullaryExpr([&] { return normal(random); });
  for (int i = -25; i < rows + 25; ++i) {
    log.truth.time_s.push_back(kBetween_s * i);
    log.truth.lines.push_back(i + 26);
    log.truth.poses.push_back(course(kBetween_s * i));
    if (i < 0 || i >= rows) continue;
    const PoseError fresh = PoseError::NullaryExpr([&] { return normal(random); });
    white = correlation * white + std::sqrt(1.0 - correlation * correlation) * fresh;
    const SpatialPose truth = course(kBetween_s * i + offset_s);
    const SE3 T = SE3(SO3(truth.orientation), truth.position) * SE3::Exp(factor * sigma.cwiseProduct(white));
    log.samples.push_back({{kBetween_s * i,
                            i + 1,
                            {T.translation(), T.rotation().quaternion()},
                            sigma.cwiseAbs2().asDiagonal()},
                           {0, 1, 2, 3, 4, 5}});
  }
  return log;
}

const TrajectoryMatching kMatching{.max_time_difference_s = 0.2};

TimeOffset found_in(const OffsetLog& log, const TrajectoryMatching& matching = kMatching) {
  return find_time_offset(log.samples, log.truth, matching, kRight, true);
}

// The interval holds the offset in 95 % of the logs, whether P is right or not, and errors are correlated.
// The truth is interpolated over 0.1 s, which moves the best time by less than a hundredth of the interval.
TEST(TimeOffset, TheIntervalHoldsTheOffsetAsOftenAsItSays) {
  constexpr int kLogs = 80;
  constexpr double kOffset_s = 0.137;
  int held = 0, told = 0;
  for (int i = 0; i < kLogs; ++i) {
    const TimeOffset offset =
        found_in(offset_log(static_cast<std::uint64_t>(i) + 1, 800, kOffset_s, 0.4, i % 2 == 0 ? 1.0 : 3.0));
    EXPECT_NEAR(offset.value_s, kOffset_s, 0.02);
    if (!offset.reason.empty()) continue;  // by chance correlated for longer than it is
    ++told;
    held += offset.lower_s <= kOffset_s && kOffset_s <= offset.upper_s ? 1 : 0;
    EXPECT_LT(offset.upper_s - offset.lower_s, 0.06);
  }
  EXPECT_GE(told, kLogs / 2);
  const double expected = 0.95 * told, deviation = std::sqrt(0.05 * expected);
  EXPECT_GE(held, expected - 5.0 * deviation);
}

TEST(TimeOffset, AnAlignedTruthIsAlignedAtEveryTime) {
  OffsetLog log = offset_log(5, 400, -0.2, 0.0);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()));
  for (SpatialPose& pose : log.truth.poses) pose = {turn * pose.position, turn * pose.orientation};
  TrajectoryMatching matching = kMatching;
  matching.alignment = TruthAlignment::yaw;
  const TimeOffset offset = found_in(log, matching);
  EXPECT_EQ(offset.reason, "");
  EXPECT_NEAR(offset.value_s, -0.2, 0.02);
}

// Of a truth at 10 Hz, within 20 ms of which an estimate lies by chance alone.
TEST(TimeOffset, ATruthTooCoarseForTheLimitIsSaidWithTheLimitThatHelps) {
  const OffsetLog log = offset_log(5, 400, 0.037, 0.0);
  TrajectoryMatching matching = kMatching;
  matching.max_time_difference_s = 0.02;
  const TimeOffset none = found_in(log, matching);
  EXPECT_THAT(none.reason,
              ::testing::AllOf(HasSubstr("a row every 0.1 s"), HasSubstr("--max-time-difference 0.15")));
  EXPECT_TRUE(std::isnan(none.value_s));
  matching.max_time_difference_s = 0.15;
  for (const TruthTime time : {TruthTime::interpolated, TruthTime::nearest}) {
    matching.truth_time = time;
    const TimeOffset found = found_in(log, matching);
    EXPECT_EQ(found.reason, "");
    EXPECT_NEAR(found.value_s, 0.037, 0.02);
  }
}

TEST(TimeOffset, WhatCannotBeToldHasAReason) {
  OffsetLog still = offset_log(1, 200, 0.0, 0.0);
  for (SpatialPose& pose : still.truth.poses) pose = course(0.0);
  EXPECT_NE(found_in(still).reason, "");
  EXPECT_THAT(found_in(offset_log(2, 400, 1.6, 0.0)).reason, HasSubstr("no time within 1 s"));
  EXPECT_THAT(found_in(offset_log(3, 200, 0.0, 0.97)).reason, HasSubstr("times as long as its errors"));
  EXPECT_THAT(found_in(offset_log(4, 5, 0.0, 0.0)).reason, HasSubstr("too few rows"));
}

// Of errors that are correlated for too long the offset of the least NEES is used, which makes them smaller
// by an unknown part.
TEST(TimeOffset, OneWithoutAnIntervalIsUsedAndOneThatIsNotFoundIsNot) {
  const auto used = [](const OffsetLog& log, TrajectoryMatching matching, testing::RecordedSink& sink) {
    return with_time_offset(log.samples, log.truth, matching, kRight, true, sink).time_offset_s.value_or(0.0);
  };
  const OffsetLog late = offset_log(6, 400, 0.1, 0.0), unknown = offset_log(2, 400, 1.6, 0.0),
                  slow = offset_log(3, 200, 0.1, 0.97);
  testing::RecordedSink silent, found, fitted, not_found, named;
  EXPECT_EQ(used(late, kMatching, silent), 0.0);
  EXPECT_EQ(silent.said(), "");
  TrajectoryMatching asked = kMatching;
  asked.find_time_offset = true;
  EXPECT_NEAR(used(late, asked, found), 0.1, 0.02);
  EXPECT_THAT(found.said(), HasSubstr("s behind those of the truth"));
  EXPECT_EQ(found.fit, TruthFit::none);
  EXPECT_NEAR(used(slow, asked, fitted), 0.1, 0.05);
  EXPECT_THAT(fitted.said(), ::testing::AllOf(HasSubstr("no interval"), HasSubstr("never pessimistic")));
  EXPECT_EQ(fitted.fit, TruthFit::least_nees);
  EXPECT_EQ(used(unknown, asked, not_found), 0.0);
  EXPECT_THAT(not_found.said(), HasSubstr("No time offset was used"));
  EXPECT_EQ(not_found.fit, TruthFit::not_found);
  asked = kMatching;
  asked.time_offset_s = -0.5;
  EXPECT_EQ(used(late, asked, named), -0.5);
  EXPECT_THAT(named.said(), HasSubstr("0.5 s ahead of those of the truth"));
}

}  // namespace
}  // namespace credence::internal
