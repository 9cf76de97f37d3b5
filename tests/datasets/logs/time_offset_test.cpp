#include "datasets/logs/time_offset.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
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

  PosesWithTruth poses() const { return {samples, std::make_shared<const Trajectory>(truth), kRight}; }
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
  const PosesWithTruth poses = log.poses();
  return find_time_offset({&poses, 1}, matching);
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
  EXPECT_THAT(found_in(offset_log(4, 5, 0.0, 0.0)).reason, HasSubstr("times as long as its errors"));
}

// Of errors that are correlated for too long the offset of the least NEES is used, which makes them smaller
// by an unknown part.
TEST(TimeOffset, OneWithoutAnIntervalIsUsedAndOneThatIsNotFoundIsNot) {
  const auto used = [](const OffsetLog& log, TrajectoryMatching matching, testing::RecordedSink& sink) {
    LogReading reading;
    reading.matching = matching;
    return with_time_offset(log.poses(), reading, sink).time_offset_s.value_or(0.0);
  };
  const OffsetLog late = offset_log(6, 400, 0.1, 0.0), unknown = offset_log(2, 400, 1.6, 0.0),
                  slow = offset_log(3, 200, 0.1, 0.97);
  testing::RecordedSink silent, found, fitted, not_found, named;
  EXPECT_EQ(used(late, kMatching, silent), 0.0);
  EXPECT_EQ(silent.said(), "");
  TrajectoryMatching asked = kMatching;
  asked.find_time_offset = TimeOffsetSearch::each;
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

/// Of one set-up: files of odometry, whose errors are never forgotten, or of another memory.
std::vector<PosesWithTruth> pool(std::uint64_t seed, int files, int rows, double offset_s,
                                 double correlation) {
  std::vector<PosesWithTruth> all;
  for (int f = 0; f < files; ++f) {
    all.push_back(
        offset_log(100 * seed + static_cast<std::uint64_t>(f), rows, offset_s, correlation).poses());
  }
  return all;
}

// No file of these is long enough for an interval of its own (2.6 correlation times); six together have one.
TEST(TimeOffset, FilesOfOneSetUpHaveOneByWhatTheFilesTell) {
  constexpr int kPools = 30;
  constexpr double kOffset_s = 0.137;
  int held = 0;
  for (int i = 0; i < kPools; ++i) {
    const std::vector<PosesWithTruth> files =
        pool(static_cast<std::uint64_t>(i) + 1, 6, 100, kOffset_s, 0.95);
    const TimeOffset offset = find_time_offset(files, kMatching);
    EXPECT_EQ(offset.reason, "");
    EXPECT_TRUE(offset.whole_files);
    EXPECT_EQ(offset.files, 6);
    EXPECT_LT(offset.upper_s - offset.lower_s, 0.1);
    held += offset.lower_s <= kOffset_s && kOffset_s <= offset.upper_s ? 1 : 0;
  }
  EXPECT_GE(held, 0.95 * kPools - 5.0 * std::sqrt(0.05 * 0.95 * kPools));
}

TEST(TimeOffset, OfAllFilesItIsTheSameForAnyNumberOfThreads) {
  const std::vector<PosesWithTruth> files = pool(7, 5, 60, 0.1, 0.5);
  const TimeOffset one = find_time_offset(files, kMatching, 1), three = find_time_offset(files, kMatching, 3);
  EXPECT_EQ(one.value_s, three.value_s);
  EXPECT_EQ(one.upper_s, three.upper_s);
  double least = 1.0, most = -1.0;
  for (const PosesWithTruth& file : files) {
    const double own = find_time_offset({&file, 1}, kMatching).value_s;
    least = std::min(least, own);
    most = std::max(most, own);
  }
  EXPECT_GT(one.value_s, least);
  EXPECT_LT(one.value_s, most);
}

TEST(TimeOffset, ThatOfAllFilesIsUsedForEach) {
  const OffsetLog log = offset_log(8, 200, 0.1, 0.0);
  testing::RecordedSink sink;
  const TimeOffset common{.value_s = 0.25,
                          .lower_s = 0.2,
                          .upper_s = 0.3,
                          .estimated = true,
                          .rows = 99,
                          .files = 4,
                          .whole_files = true,
                          .taken = 0.05};
  LogReading options;
  options.matching.find_time_offset = TimeOffsetSearch::together;
  options.common_offset = std::make_shared<const TimeOffset>(common);
  EXPECT_EQ(with_time_offset(log.poses(), options, sink).time_offset_s, 0.25);
  EXPECT_THAT(sink.said(), ::testing::AllOf(HasSubstr("One time offset of all 4 files together"),
                                            HasSubstr("how the files differ"), HasSubstr("at most 5.0 %")));
}

// What an offset may have taken out of the errors decides what these are evidence of.
TEST(TimeOffset, OneThatTakesMuchLeavesLittleEvidence) {
  TimeOffset offset{.value_s = 0.1, .lower_s = 0.0, .upper_s = 0.2, .estimated = true, .taken = 0.09};
  EXPECT_EQ(fit_of(offset), TruthFit::none);
  offset.taken = 0.11;
  EXPECT_EQ(fit_of(offset), TruthFit::least_nees);
  offset.p_agreement = 0.001;
  EXPECT_EQ(fit_of(offset), TruthFit::not_found);
  offset.estimated = false;
  EXPECT_EQ(fit_of(offset), TruthFit::none);
}

TEST(TimeOffset, FilesWithClocksOfTheirOwnAreTold) {
  std::vector<PosesWithTruth> files = pool(9, 2, 300, 0.1, 0.0);
  EXPECT_TRUE(std::isnan(find_time_offset(files, kMatching).p_agreement));
  files.push_back(offset_log(10, 300, 0.3, 0.0).poses());
  const TimeOffset offset = find_time_offset(files, kMatching);
  EXPECT_LT(offset.p_agreement, 0.01);
  EXPECT_NEAR(offset.least_s, 0.1, 0.05);
  EXPECT_NEAR(offset.most_s, 0.3, 0.05);
  EXPECT_EQ(fit_of(offset), TruthFit::not_found);
}

}  // namespace
}  // namespace credence::internal
