#include "reports/document/replay/replay_judgement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "core/manifold/rotation.h"

namespace credence::internal {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kStretch = 0.1;     // of the map against the survey
constexpr double kVariance = 0.016;  // of every coordinate of the map

/// A minute with two observations a second, whose whitened innovations are normals times `deviation`, a GPS
/// that is met each second, and a map that is the survey of a square stretched by a tenth and moved.
ReportedReplay one_replay(double deviation = 1.0, unsigned seed = 1) {
  ReportedReplay replay;
  ReplayResult& r = replay.result;
  r.dataset = "carpark";
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 600; ++k) {
    ReplayObservation o;
    o.time_s = 0.5 * k;
    o.whitened = deviation * RangeBearing(normal(bits), normal(bits));
    o.nis = 0.5 + 0.001 * k;
    o.first_of_batch = k % 2 == 0;
    r.records.push_back(o);
  }
  for (int k = 0; k < 60; ++k) {
    ReplayReference reference;
    reference.time_s = 0.5 + k;
    reference.nees = 1.0 + 0.05 * k;
    r.references.push_back(reference);
  }
  r.vehicle_nees.expected = 2.0;
  r.survey_m = {Point(1.0, 1.0), Point(-1.0, 1.0), Point(-1.0, -1.0), Point(1.0, -1.0)};
  for (int i = 0; i < 4; ++i) {
    ReplayLandmark landmark;
    landmark.landmark = i;
    landmark.position =
        rotation(0.25) * ((1.0 + kStretch) * r.survey_m[static_cast<std::size_t>(i)]) + Point(0.5, -0.25);
    r.map.push_back(landmark);
  }
  r.map_covariance = kVariance * Matrix::Identity(8, 8);
  return replay;
}

ReplayJudgement judge_one(const ReportedReplay& replay) { return judge_replays({&replay, 1}); }

TEST(ReplayJudgement, WithoutAGateEveryUpdateCountsByItsWhitenedInnovation) {
  ReportedReplay replay = one_replay();
  for (const ObservationOutcome other :
       {ObservationOutcome::rejected, ObservationOutcome::initialised, ObservationOutcome::unassociated,
        ObservationOutcome::update_failed}) {
    ReplayObservation o;
    o.outcome = other;
    o.whitened = RangeBearing(100.0, 100.0);
    replay.result.records.push_back(o);
  }
  double sum = 0.0;
  RangeBearing mean = RangeBearing::Zero();
  for (std::size_t k = 0; k < 600; ++k) {
    sum += replay.result.records[k].whitened.squaredNorm();
    mean += replay.result.records[k].whitened / 600.0;
  }
  const InnovationTests tests = judge_one(replay).innovations;
  EXPECT_EQ(tests.nis.count, 600);
  EXPECT_NEAR(tests.nis.mean, sum / 600.0, 1e-12);
  EXPECT_EQ(tests.nis.expected, 2.0);
  EXPECT_EQ(tests.nis.verdict, Verdict::consistent);
  EXPECT_NEAR(tests.noise_scale.scale, sum / 1200.0, 1e-12) << "the mean over what is expected";
  ASSERT_EQ(tests.mean.size(), 2);
  EXPECT_LT((tests.mean - mean).norm(), 1e-12);
}

// −2 ln(1 − 0.99) = 9.21, below which χ² of two dof has the mean 1.907 (theory, section 7).
TEST(ReplayJudgement, WithAGateTheFirstOfEachBatchCountsByItsOwnNis) {
  ReportedReplay replay = one_replay();
  replay.result.settings.filter.gate = 0.99;
  double sum = 0.0;
  for (std::size_t k = 0; k < 600; k += 2) sum += replay.result.records[k].nis;
  const ReplayJudgement judgement = judge_one(replay);
  EXPECT_EQ(judgement.innovations.nis.count, 300);
  EXPECT_NEAR(judgement.innovations.nis.mean, sum / 300.0, 1e-12);
  EXPECT_NEAR(judgement.innovations.nis.expected, 1.907, 5e-4);
  EXPECT_THAT(judgement.limits, Contains(HasSubstr("had to pass a gate of 99")));
  EXPECT_THAT(judge_one(one_replay()).limits, Not(Contains(HasSubstr("gate"))));
}

TEST(ReplayJudgement, TheNeesIsThatOfTheLastReferenceOfEverySecond) {
  ReportedReplay replay = one_replay();
  ReplayReference singular = replay.result.references.back();
  singular.singular = true;
  singular.nees = 1e9;
  replay.result.references.push_back(singular);
  const RecordedNeesVerdict nees = judge_one(replay).nees;
  EXPECT_EQ(nees.verdict.steps_tested, 60);
  EXPECT_NEAR(nees.verdict.mean, 1.0 + 0.05 * 29.5, 1e-12);
  EXPECT_EQ(nees.verdict.expected, 2.0);
  for (int k = 59; k > 0; --k) {  // one more in every second, before the one that counts
    ReplayReference early = replay.result.references[static_cast<std::size_t>(k)];
    early.time_s -= 0.25;
    early.nees = 500.0;
    replay.result.references.insert(replay.result.references.begin() + k, early);
  }
  EXPECT_NEAR(judge_one(replay).nees.verdict.mean, 1.0 + 0.05 * 29.5, 1e-12);
  replay.result.vehicle_nees.expected = 3.0;
  EXPECT_EQ(judge_one(replay).nees.verdict.expected, 3.0) << "of a whole pose";
}

// A stretch about the centre is no rigid motion: 8 ε² off in all, wherever the map lies.
TEST(ReplayJudgement, TheShapeOfTheMapIsWhatNoRigidMotionMends) {
  const ReportedReplay replay = one_replay();
  const ReplayJudgement judgement = judge_one(replay);
  ASSERT_EQ(judgement.maps.size(), 1U);
  const NormalisedError &placed = judgement.maps[0].placed, &shape = judgement.maps[0].shape;
  ASSERT_TRUE(placed.ok && shape.ok);
  EXPECT_EQ(shape.dof, 5);
  EXPECT_NEAR(shape.value, 8.0 * kStretch * kStretch / kVariance, 1e-9);
  double squares = 0.0;
  for (const ReplayLandmark& landmark : replay.result.map) {
    squares += (landmark.position - replay.result.survey_m[static_cast<std::size_t>(landmark.landmark)])
                   .squaredNorm();
  }
  EXPECT_EQ(placed.dof, 8);
  EXPECT_NEAR(placed.value, squares / kVariance, 1e-9);
}

TEST(ReplayJudgement, AMapThatTheSurveyDoesNotKnowIsNotJudgedAndSaysWhy) {
  ReportedReplay replay = one_replay();
  replay.result.map[2].landmark = -1;
  const MapConsistency unknown = judge_one(replay).maps.front();
  EXPECT_FALSE(unknown.placed.ok || unknown.shape.ok);
  EXPECT_EQ(unknown.placed.reason, "the survey does not know every landmark of the map");
  EXPECT_EQ(unknown.shape.reason, unknown.placed.reason);
  replay.result.map.clear();
  replay.result.map_covariance = Matrix();
  EXPECT_EQ(judge_one(replay).maps.front().placed.reason, "the map is empty");
}

TEST(ReplayJudgement, LimitsSayWhatTheReferenceTells) {
  ReportedReplay replay = one_replay();
  EXPECT_THAT(judge_one(replay).limits.front(), StartsWith("GPS gives no heading"));
  EXPECT_THAT(judge_one(replay).limits.front(), HasSubstr("One run is no sample of runs"));
  const ReportedReplay both[] = {replay, one_replay(1.0, 2)};
  EXPECT_THAT(judge_replays(both).limits.front(), Not(HasSubstr("One run is no sample")));
  for (ReplayReference& reference : replay.result.references) reference.dof = 3;
  replay.result.settings.truth.heading_std_deg = 1.5;
  EXPECT_THAT(judge_one(replay).limits.front(), HasSubstr("known to 1.5° only"));
}

TEST(ReplayJudgement, LimitsSayWhatInflationAndTrueJacobiansMean) {
  ReportedReplay replay = one_replay();
  EXPECT_THAT(judge_one(replay).limits, Not(Contains(HasSubstr("inflated"))));
  EXPECT_THAT(judge_one(replay).limits, Not(Contains(HasSubstr("Jacobians at the truth"))));
  replay.result.settings.filter.inflation = Inflation::map;
  replay.ideal = replay.result;
  EXPECT_THAT(judge_one(replay).limits, Contains(StartsWith("P is inflated to decorrelate it")));
  EXPECT_THAT(judge_one(replay).limits, Contains(StartsWith("Jacobians at the truth are no filter")));
  EXPECT_THAT(judge_replays({&replay, 1}, 0.99).limits.back(), StartsWith("All verdicts at 99"));
}

// Innovations ten times smaller than S says want variances a hundredth of theirs; the map's shape is five
// where five is expected.
TEST(ReplayJudgement, AScaleThatWouldBreakTheMapIsSaidNotToSuitBoth) {
  const ReplayJudgement small = judge_one(one_replay(0.1));
  EXPECT_NEAR(small.innovations.noise_scale.scale, 0.01, 0.002);
  EXPECT_THAT(small.limits, Contains(HasSubstr("no single scale suits both")));
  EXPECT_THAT(judge_one(one_replay()).limits, Not(Contains(HasSubstr("no single scale"))));
  const ReportedReplay two[] = {one_replay(0.1), one_replay(0.1, 2)};
  EXPECT_THAT(judge_replays(two).limits, Not(Contains(HasSubstr("no single scale")))) << "of one map alone";
}

TEST(ReplayJudgement, InnovationsThatAreNotWhiteLimitTheirSum) {
  ReportedReplay replay = one_replay();
  RangeBearing last = RangeBearing::Zero();
  for (ReplayObservation& o : replay.result.records) {
    o.whitened = last = 0.9 * last + std::sqrt(1.0 - 0.81) * o.whitened;
  }
  EXPECT_FALSE(judge_one(replay).innovations.whiteness.white);
  EXPECT_THAT(judge_one(replay).limits, Contains(HasSubstr("assume white innovations, which these are not")));
  EXPECT_THAT(judge_one(one_replay()).limits, Not(Contains(HasSubstr("assume white innovations"))));
}

TEST(ReplayJudgement, RunsWithDifferentGatesAreRefused) {
  ReportedReplay replays[] = {one_replay(), one_replay(1.0, 2)};
  EXPECT_EQ(judge_replays(replays).maps.size(), 2U);
  EXPECT_EQ(judge_replays(replays).innovations.nis.count, 1200);
  replays[1].result.settings.filter.gate = 0.95;
  EXPECT_THROW(judge_replays(replays), std::invalid_argument);
}

TEST(ReplayName, HasTheRunWhereThereAreSeveral) {
  ReplayResult result;
  result.dataset = "mrclam";
  EXPECT_EQ(replay_name(result), "mrclam");
  result.run = "robot 1";
  EXPECT_EQ(replay_name(result), "mrclam, robot 1");
}

}  // namespace
}  // namespace credence::internal
