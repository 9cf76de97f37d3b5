#include "datasets/logs/truth_gaps.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "datasets/logs/conventions/pose_error.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int kPerSecond = 20;

Trajectory empty_truth() {
  Trajectory truth;
  truth.file = "truth.txt";
  return truth;
}

void append_pose(Trajectory& to, double time_s, const SpatialPose& pose) {
  to.time_s.push_back(time_s);
  to.poses.push_back(pose);
  to.lines.push_back(std::ssize(to.time_s));
}

SpatialPose on_curve(double t) {
  return {{10.0 * std::sin(0.7 * t), 8.0 * std::cos(0.5 * t), 0.0},
          Eigen::Quaterniond(Eigen::AngleAxisd(2.0 * std::sin(0.4 * t), Eigen::Vector3d::UnitZ()))};
}

Trajectory trajectory_on_a_curve(int seconds) {
  Trajectory fine = empty_truth();
  for (int k = 0; k <= seconds * kPerSecond; ++k) {
    const double t = static_cast<double>(k) / kPerSecond;
    append_pose(fine, t, on_curve(t));
  }
  return fine;
}

/// A random walk of the position, or of its velocity.
Trajectory walk(int seconds, bool of_velocity) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Trajectory fine = empty_truth();
  Eigen::Vector3d state = Eigen::Vector3d::Zero(), position = Eigen::Vector3d::Zero();
  for (int k = 0; k <= seconds * kPerSecond; ++k) {
    append_pose(fine, static_cast<double>(k) / kPerSecond, {of_velocity ? position : state});
    for (double& x : state) x += normal(random) / std::sqrt(kPerSecond);
    position += state / kPerSecond;
  }
  return fine;
}

Trajectory each_second_of(const Trajectory& fine) {
  Trajectory truth = empty_truth();
  for (std::size_t i = 0; i < fine.poses.size(); i += kPerSecond)
    append_pose(truth, fine.time_s[i], fine.poses[i]);
  return truth;
}

const TrajectoryMatching kAnyGap{.max_time_difference_s = 100.0};

/// The mean squares of what the truth is off at times between its rows, over those of what is told of it.
struct Squares {
  double position, rotation;
};

Squares real_over_told(const Trajectory& fine, const Trajectory& truth) {
  const TruthGaps gaps(truth, kAnyGap);
  Squares real{}, told{};
  for (std::size_t i = 0; i < fine.poses.size(); ++i) {
    const std::vector<TruthDeviation> off = gaps.at(fine.time_s[i]);
    if (off.size() < 2) continue;
    const SpatialPose line = truth_at(truth, fine.time_s[i], kAnyGap)->pose;
    real.position += (fine.poses[i].position - line.position).squaredNorm();
    real.rotation += rotation_log(line.orientation.conjugate() * fine.poses[i].orientation).squaredNorm();
    told.position += std::max(off[0].position.squaredNorm(), off[1].position.squaredNorm());
    told.rotation += std::max(off[0].rotation.squaredNorm(), off[1].rotation.squaredNorm());
  }
  return {real.position / told.position, real.rotation / told.rotation};
}

TEST(TruthGaps, WhatIsToldIsNoLessThanWhatTheTruthIsOffAndNoMoreThanThreeTimesIt) {
  constexpr double kNoise = 9.0;  // of a square: three times
  const auto is_near = [&](double ratio) { return ratio > 1.0 / kNoise && ratio <= 1.0; };
  const Trajectory on_a_curve = trajectory_on_a_curve(300), position = walk(2000, false),
                   velocity = walk(2000, true);
  const Squares of_curve = real_over_told(on_a_curve, each_second_of(on_a_curve));
  EXPECT_PRED1(is_near, of_curve.position);
  EXPECT_PRED1(is_near, of_curve.rotation);
  EXPECT_PRED1(is_near, real_over_told(position, each_second_of(position)).position);
  EXPECT_PRED1(is_near, real_over_told(velocity, each_second_of(velocity)).position);
}

TEST(TruthGaps, NoiseOfTheTruthIsNoMotion) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  Trajectory at_rest = each_second_of(trajectory_on_a_curve(2000));
  for (SpatialPose& pose : at_rest.poses) {
    pose = {};
    for (double& x : pose.position) x = normal(random);
  }
  const TruthGaps gaps(at_rest, kAnyGap);
  double told = 0.0;
  for (int i = 100; i < 1900; ++i) told += gaps.at(i + 0.5)[0].position.squaredNorm() / 1800.0;
  EXPECT_LT(told, 0.3) << "of 3 that each row is off";
}

TEST(TruthGaps, ALongerGapTellsMore) {
  const Trajectory fine = trajectory_on_a_curve(300);
  Trajectory truth = each_second_of(fine);
  const auto cut = [](auto& of, int from, int to) { of.erase(of.begin() + from, of.begin() + to); };
  cut(truth.time_s, 101, 104);
  cut(truth.poses, 101, 104);
  cut(truth.lines, 101, 104);
  const TruthGaps gaps(truth, kAnyGap);
  const double off = (on_curve(102.0).position - truth_at(truth, 102.0, kAnyGap)->pose.position).norm();
  double told = 0.0;
  for (const TruthDeviation& d : gaps.at(102.0)) told = std::max(told, d.position.norm());
  EXPECT_GT(told, 0.5 * off);
  EXPECT_GT(off, 10.0 * gaps.at(90.5)[0].position.norm());
}

TEST(TruthGaps, ATimeOfARowHasNoGap) {
  const Trajectory truth = each_second_of(trajectory_on_a_curve(100));
  EXPECT_THAT(TruthGaps(truth, kAnyGap).at(30.0), IsEmpty());
  EXPECT_THAT(TruthGaps(truth, kAnyGap).at(30.0 + 0.5 * kSameTime_s), IsEmpty());
  EXPECT_THAT(TruthGaps(truth, kAnyGap).at(30.5), SizeIs(2));
  EXPECT_THAT(TruthGaps(truth, kAnyGap).at(0.5), SizeIs(1)) << "before the first row there is none";
  TrajectoryMatching late = kAnyGap;
  late.time_offset_s = 0.5;
  EXPECT_THAT(TruthGaps(truth, late).at(29.5), IsEmpty());
}

TEST(TruthGaps, OfTheNearestRowTheTruthMovesOn) {
  Trajectory truth = empty_truth();
  for (int i = 0; i < 3; ++i) append_pose(truth, i, {Eigen::Vector3d(4.0 * i, 0.0, 0.0)});
  const TruthGaps gaps(truth, {.max_time_difference_s = 1.0, .truth_time = TruthTime::nearest});
  ASSERT_THAT(gaps.at(1.25), SizeIs(3));
  EXPECT_DOUBLE_EQ(gaps.at(1.25)[0].position.x(), 1.0);
  EXPECT_DOUBLE_EQ(gaps.at(0.75)[0].position.x(), -1.0);
  EXPECT_DOUBLE_EQ(gaps.at(2.5)[0].position.x(), 2.0) << "behind the last row it goes on";
}

/// Estimates whose errors are white and of this σ, in every coordinate.
Trajectory estimate_of(const Trajectory& fine, double sigma) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, sigma);
  Trajectory estimate = fine;
  estimate.file = "estimate.tum";
  for (SpatialPose& pose : estimate.poses) {
    Eigen::Vector3d turn;
    for (double& x : pose.position) x += normal(random);
    for (double& x : turn) x = normal(random);
    pose.orientation = pose.orientation * Eigen::AngleAxisd(turn.norm(), turn.normalized()).inverse();
    estimate.covariances.push_back(sigma * sigma * PoseCovariance::Identity());
  }
  return estimate;
}

// A walk tells of one gap nothing by the others: those where it is small by chance would be taken.
TEST(TruthGaps, OfAWalkNoGapIsChosenByChance) {
  const Trajectory fine = walk(2000, false);
  const Trajectory truth = each_second_of(fine);
  for (const TruthTime truth_time : {TruthTime::interpolated, TruthTime::nearest}) {
    TrajectoryMatching matching = kAnyGap;
    matching.truth_time = truth_time;
    const TruthGaps gaps(truth, matching);
    double least = 1e9;
    for (int i = 100; i < 1900; ++i) {
      double most = 0.0;
      for (const TruthDeviation& d : gaps.at(i + 0.5)) most = std::max(most, d.position.norm());
      least = std::min(least, most);
    }
    EXPECT_GT(least, 0.5) << "of the root of 3/4 that it departs";
  }
}

TEST(TruthGaps, ARightFilterIsRightByATruthThatIsSlower) {
  const Trajectory fine = trajectory_on_a_curve(300), estimate = estimate_of(fine, 0.1);
  for (const TruthTime truth_time : {TruthTime::interpolated, TruthTime::nearest}) {
    TrajectoryMatching matching = kAnyGap;
    matching.truth_time = truth_time;
    testing::RecordedSink sink;
    const TrajectoryErrors errors =
        trajectory_errors(estimate, each_second_of(fine), matching, nullptr, &sink);
    const auto rows = static_cast<double>(errors.rows.size());
    double nees = 0.0;
    for (const Step& step : errors.rows) nees += step.error.dot(step.P.ldlt().solve(step.error)) / rows;
    EXPECT_GE(rows, 301.0);
    EXPECT_LT(rows, 0.7 * static_cast<double>(estimate.poses.size()));
    EXPECT_LT(std::abs(nees - 6.0), 5.0 * std::sqrt(12.0 / rows));
    EXPECT_THAT(sink.said(), HasSubstr("rows are left out, "));
  }
}

TEST(TruthGaps, WhereNoRowIsLeftItSaysWhatWouldLeaveSome) {
  const Trajectory fine = trajectory_on_a_curve(100);
  Trajectory estimate = estimate_of(fine, 1e-6);
  for (double& t : estimate.time_s) t += 0.01;
  estimate.time_s.back() = 99.5;
  const Trajectory truth = each_second_of(fine);
  testing::RecordedSink sink;
  const auto said = [&](TruthTime truth_time) -> std::string {
    TrajectoryMatching matching = kAnyGap;
    matching.truth_time = truth_time;
    try {
      trajectory_errors(estimate, truth, matching, nullptr, &sink);
    } catch (const DataError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(said(TruthTime::interpolated),
              HasSubstr("estimate.tum: all 2001 rows are left out, whose truth"));
  EXPECT_THAT(said(TruthTime::interpolated), HasSubstr("--truth-time nearest"));
  EXPECT_THAT(said(TruthTime::nearest), HasSubstr("--truth-time interpolated"));
}

TEST(TruthGaps, ATruthOfFewRowsIsAtRestOrSteady) {
  Trajectory truth = empty_truth();
  append_pose(truth, 0.0, {});
  EXPECT_THAT(TruthGaps(truth, kAnyGap).at(0.5), IsEmpty());
  for (int i = 1; i < 4; ++i) append_pose(truth, i, {Eigen::Vector3d(i * i, 0.0, 0.0)});
  EXPECT_NEAR(TruthGaps(truth, kAnyGap).at(1.5)[0].position.x(), -0.25, 1e-12)
      << "x = t² lies a quarter below its chord in the middle";
}

}  // namespace
}  // namespace credence::internal
