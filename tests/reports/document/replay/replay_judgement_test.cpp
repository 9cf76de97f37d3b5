#include "reports/document/replay/replay_judgement.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "core/manifold/rotation.h"
#include "datasets/data_error.h"
#include "tests/datasets/replay/replay_world.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
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
    o.innovation = o.whitened;
    o.S.setIdentity();
    o.first_of_batch = k % 2 == 0;
    r.records.push_back(o);
  }
  for (int k = 0; k < 60; ++k) {
    ReplayReference reference;
    reference.time_s = 0.5 + k;
    reference.estimate = Pose(normal(bits), normal(bits), 0.0);
    reference.truth.setZero();
    reference.covariance.setIdentity();
    r.references.push_back(reference);
    r.vehicle_nees.add(reference.estimate.squaredNorm());
  }
  r.vehicle_nees.expected = 2.0;
  r.settings.truth.position_std = 0.0;
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

const Judgement& judgement_of(const ReplayJudgement& judgement) { return judgement.logs.analysis.judgement; }

TEST(ReplayJudgement, WithoutAGateEveryUpdateCountsByItsWhitenedInnovation) {
  ReportedReplay replay = one_replay();
  double sum = 0.0;
  for (std::size_t k = 0; k < 600; ++k) sum += replay.result.records[k].whitened.squaredNorm();
  for (const ObservationOutcome other :
       {ObservationOutcome::rejected, ObservationOutcome::initialised, ObservationOutcome::unassociated,
        ObservationOutcome::update_failed}) {
    ReplayObservation o;
    o.outcome = other;
    o.whitened = RangeBearing(100.0, 100.0);
    replay.result.records.push_back(o);
  }
  const ReplayJudgement judgement = judge_one(replay);
  const ConsistencyVerdict& nis = judgement_of(judgement).nis;
  EXPECT_EQ(nis.count, 600);
  EXPECT_NEAR(nis.mean, sum / 600.0, 1e-9);
  EXPECT_EQ(nis.expected, 2.0);
  EXPECT_EQ(nis.verdict, Verdict::consistent);
  EXPECT_NEAR(judgement.noise_scale.scale, sum / 1200.0, 1e-9) << "the mean over what is expected";
  EXPECT_EQ(judgement_of(judgement).scale_innovation.upper, judgement.noise_scale.upper);
}

// −2 ln(1 − 0.99) = 9.21, below which χ² of two dof has the mean 1.907 (theory, section 7).
TEST(ReplayJudgement, WithAGateTheFirstOfEachBatchCountsByItsOwnNis) {
  ReportedReplay replay = one_replay();
  replay.result.settings.filter.gate = 0.99;
  double sum = 0.0;
  for (std::size_t k = 0; k < 600; k += 2) sum += replay.result.records[k].innovation.squaredNorm();
  const ReplayJudgement judgement = judge_one(replay);
  EXPECT_EQ(judgement_of(judgement).nis.count, 300);
  EXPECT_NEAR(judgement_of(judgement).nis.mean, sum / 300.0, 1e-9);
  EXPECT_NEAR(judgement_of(judgement).nis.expected, 1.907, 5e-4);
  EXPECT_THAT(judgement.logs.remarks, Contains(HasSubstr("had to pass a gate of 99")));
  EXPECT_THAT(judge_one(one_replay()).logs.remarks, Not(Contains(HasSubstr("gate"))));
}

TEST(ReplayJudgement, TheNeesIsThatOfEveryReference) {
  const ReportedReplay replay = one_replay();
  const ReplayJudgement judgement = judge_one(replay);
  const ConsistencyVerdict& nees = judgement_of(judgement).nees;
  EXPECT_EQ(nees.count, 60);
  EXPECT_NEAR(nees.mean, replay.result.vehicle_nees.mean(), 1e-12);
  EXPECT_EQ(nees.expected, 2.0);
  EXPECT_FALSE(is_inconsistent(judgement_of(judgement).word.verdict));
}

// The whole judge on the filter itself where its assumptions hold: at most 5 % are accused, within 5 standard
// errors of the binomial count, and R of half its variance is found.
TEST(ReplayJudgement, AReplayWhoseAssumptionsHoldIsSeldomAccused) {
  constexpr int kReplays = 60;
  int accused = 0;
  for (unsigned seed = 1; seed <= kReplays; ++seed) {
    const ReportedReplay replay{test::ReplayWorld().run(seed, 60), {}};
    accused += is_inconsistent(judgement_of(judge_one(replay)).word.verdict) ? 1 : 0;
  }
  EXPECT_LE(accused, 0.05 * kReplays + 5.0 * std::sqrt(0.05 * 0.95 * kReplays));
  const ReportedReplay noisy{test::ReplayWorld().run(1, 60, std::sqrt(2.0)), {}};
  EXPECT_EQ(judgement_of(judge_one(noisy)).nis.verdict, Verdict::optimistic);
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
  EXPECT_THAT(judge_one(replay).logs.remarks.front(), StartsWith("GPS gives no heading"));
  for (ReplayReference& reference : replay.result.references) reference.dof = 3;
  replay.result.settings.truth.heading_std_deg = 1.5;
  EXPECT_THAT(judge_one(replay).logs.remarks.front(), HasSubstr("known to 1.5° only"));
}

TEST(ReplayJudgement, LimitsSayWhatInflationAndTrueJacobiansMean) {
  ReportedReplay replay = one_replay();
  EXPECT_THAT(judge_one(replay).logs.remarks, Not(Contains(HasSubstr("inflated"))));
  EXPECT_THAT(judge_one(replay).logs.remarks, Not(Contains(HasSubstr("Jacobians at the truth"))));
  replay.result.settings.filter.inflation = Inflation::map;
  replay.ideal = replay.result;
  EXPECT_THAT(judge_one(replay).logs.remarks, Contains(StartsWith("P is inflated to decorrelate it")));
  ReplayMean& own = replay.result.vehicle_nees;
  ReplayMean& ideal = replay.ideal->vehicle_nees;
  own = ideal = {.sum = 120.0, .count = 10, .expected = 2.0};
  const auto told = [&](double sum_of_ideal, const char* share) {
    ideal.sum = sum_of_ideal;
    EXPECT_THAT(judge_one(replay).logs.remarks,
                Contains(AllOf(StartsWith("With Jacobians at the truth the mean NEES of the vehicle is "),
                               HasSubstr(" instead of 12.00, where 2.000 is expected"),
                               HasSubstr(fmt::format(" is {} of what is too much", share)))));
    EXPECT_EQ(judge_one(replay).logs.explained,
              std::string(share) == "most" ? Verdict::optimistic : Verdict::undecided);
  };
  told(69.0, "most");
  told(71.0, "a part");
  told(109.0, "a part");
  told(111.0, "no part");
  told(150.0, "no part");
}

// The innovations alone spoke, of an R that is too large, where the errors are thirty times what P says.
TEST(ReplayJudgement, TheLinearisationIsTheFirstCauseWhereItIsMostOfWhatIsTooMuch) {
  ReportedReplay replay = one_replay(0.7);
  for (ReplayReference& reference : replay.result.references) reference.estimate *= 6.0;
  replay.ideal = replay.result;
  replay.result.vehicle_nees = {.sum = 720.0, .count = 10, .expected = 2.0};
  replay.ideal->vehicle_nees = {.sum = 700.0, .count = 10, .expected = 2.0};
  const auto causes = [&] {
    const ReplayJudgement judgement = judge_one(replay);
    std::vector<Cause> all;
    for (const CauseFound& found : judgement_of(judgement).causes) all.push_back(found.cause);
    return all;
  };
  EXPECT_THAT(causes(), Not(Contains(Cause::linearisation)));
  const std::vector<Cause> others = causes();
  replay.ideal->vehicle_nees.sum = 100.0;
  std::vector<Cause> with_it = {Cause::linearisation};
  with_it.insert(with_it.end(), others.begin(), others.end());
  EXPECT_EQ(causes(), with_it);
  EXPECT_THAT(judge_one(replay).logs.advice(),
              Contains(HasSubstr("— with Jacobians at the truth mean NEES of the vehicle is 10.00 instead of "
                                 "72.00, where 2.000 is expected; ")));
  for (ReplayReference& reference : replay.result.references) reference.estimate /= 6.0;
  EXPECT_THAT(causes(), Not(Contains(Cause::linearisation))) << "NEES is as it should be";
}

// Innovations ten times smaller than S says want variances a hundredth of theirs; the map's shape is five
// where five is expected.
TEST(ReplayJudgement, AScaleThatWouldBreakTheMapIsSaidNotToSuitBoth) {
  const ReplayJudgement small = judge_one(one_replay(0.1));
  EXPECT_NEAR(small.noise_scale.scale, 0.01, 0.002);
  EXPECT_THAT(small.logs.remarks, Contains(HasSubstr("no single scale suits both")));
  EXPECT_THAT(judge_one(one_replay()).logs.remarks, Not(Contains(HasSubstr("no single scale"))));
  const ReportedReplay two[] = {one_replay(0.1), one_replay(0.1, 2)};
  EXPECT_THAT(judge_replays(two).logs.remarks, Not(Contains(HasSubstr("no single scale"))))
      << "of one map alone";
}

TEST(ReplayJudgement, InnovationsThatAreNotWhiteLimitTheirSum) {
  ReportedReplay replay = one_replay();
  RangeBearing last = RangeBearing::Zero();
  for (ReplayObservation& o : replay.result.records) {
    o.whitened = last = 0.9 * last + std::sqrt(1.0 - 0.81) * o.whitened;
  }
  EXPECT_FALSE(judgement_of(judge_one(replay)).sensors.at(0).whiteness.white);
  EXPECT_THAT(judge_one(replay).logs.remarks,
              Contains(HasSubstr("assume white innovations, which these are not")));
  EXPECT_THAT(judge_one(one_replay()).logs.remarks, Not(Contains(HasSubstr("assume white innovations"))));
}

TEST(ReplayJudgement, RunsWithDifferentGatesAreRefused) {
  ReportedReplay replays[] = {one_replay(), one_replay(1.0, 2)};
  EXPECT_EQ(judge_replays(replays).maps.size(), 2U);
  EXPECT_EQ(judgement_of(judge_replays(replays)).nis.count, 1200);
  replays[1].result.settings.filter.gate = 0.95;
  EXPECT_THROW(judge_replays(replays), std::invalid_argument);
}

// Steps have times only where all runs agree on them.
TEST(ReplayJudgement, RunsOfDifferentTimesAreJudgedByTheirRows) {
  ReportedReplay replays[] = {one_replay(), one_replay(1.0, 2)};
  EXPECT_NE(judgement_of(judge_replays(replays)).nees.times, nullptr);
  for (ReplayObservation& o : replays[1].result.records) o.time_s *= 3.0;
  for (ReplayReference& reference : replays[1].result.references) reference.time_s *= 3.0;
  EXPECT_EQ(judgement_of(judge_replays(replays)).nees.times, nullptr);
}

TEST(ReplayJudgement, AReplayThatIsThereTwiceIsRefused) {
  const ReportedReplay replays[] = {one_replay(), one_replay()};
  EXPECT_THROW(judge_replays(replays), DataError);
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
