#include "datasets/replay/replay_slam.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

using Seen = Observation<PlanarModel>;

ReplaySlamInputs inputs() {
  ReplaySlamInputs told;
  told.vehicle = Vehicle{VehicleKind::car, {}};
  told.Q = Eigen::Vector2d(0.04, 0.01).asDiagonal();
  told.R = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  told.survey_m = {{10.0, 2.0}, {8.0, -4.0}, {-3.0, 9.0}};
  return told;
}

ReplaySettings settings_of(const std::string& estimator) {
  ReplaySettings settings = carpark_settings();
  settings.filter = {};
  settings.filter.estimator = estimator;
  return settings;
}

Eigen::Matrix3d start_covariance() { return Eigen::Vector3d(0.01, 0.02, 0.001).asDiagonal(); }

/// A filter that has seen the first two landmarks and driven on.
std::unique_ptr<ReplaySlam> on_its_way(const std::string& estimator, const ReplaySlamInputs& told) {
  auto filter = make_replay_slam(settings_of(estimator), told);
  filter->reset(Pose(0.0, 0.0, 0.1), start_covariance());
  filter->predict(Control(1.0, 0.05), 0.5, std::nullopt);
  const Seen seen[] = {{0, RangeBearing(9.6, 0.1)}, {1, RangeBearing(8.5, -0.6)}};
  EXPECT_TRUE(filter->update(seen).ok);
  filter->predict(Control(1.1, 0.02), 0.5, std::nullopt);
  filter->prepare_to_judge();
  return filter;
}

TEST(ReplaySlam, WhatItJudgesOfAnObservationIsWhatTheUpdateThenFinds) {
  const RangeBearing z(9.2, 0.15);
  for (const char* estimator : {"ekf", "fej", "oc", "invariant"}) {
    const auto filter = on_its_way(estimator, inputs());
    const ReplaySlam::Compatibility judged = filter->judge(z, 0);
    const Matrix before = filter->covariance();
    EXPECT_EQ(filter->covariance(), before) << estimator << ": judging changes nothing";
    const Seen seen[] = {{0, z}};
    const UpdateResult result = filter->update(seen);
    ASSERT_TRUE(result.ok) << estimator;
    EXPECT_EQ(result.dof, 2) << estimator;
    EXPECT_NEAR(judged.nis, result.nis, 1e-9 * result.nis) << estimator;
    EXPECT_LT((judged.innovation - Vector(filter->innovation())).norm(), 1e-12) << estimator;
    EXPECT_LT((judged.S - Matrix(filter->innovation_covariance())).norm(), 1e-12) << estimator;
    EXPECT_LT(filter->covariance().trace(), before.trace()) << estimator;
  }
}

TEST(ReplaySlam, TheCovarianceOfAnObservationOfAnAnchorIsThatOfThePoseAndTheNoise) {
  // S = H_r P Hᵀ_r + R with H_r by differences of the range and bearing of a point at a known place.
  ReplaySlamInputs told = inputs();
  told.anchors = {{2, told.survey_m[2]}};
  const auto filter = on_its_way("ekf", told);
  EXPECT_EQ(filter->offset_of(2), -1) << "an anchor is no state";
  const auto seen_from = [&](const Pose& pose) {
    const Point d = told.survey_m[2] - Point(pose.head<2>());
    return RangeBearing(d.norm(), wrap_angle(std::atan2(d.y(), d.x()) - pose[2]));
  };
  const Pose pose = filter->pose();
  Eigen::Matrix<double, 2, 3> H;
  for (Index i = 0; i < 3; ++i) {
    const Pose step = 1e-6 * Pose::Unit(i);
    H.col(i) = (seen_from(pose + step) - seen_from(pose - step)) / 2e-6;
  }
  const RangeBearing z = seen_from(pose) + RangeBearing(0.3, -0.02);
  const ReplaySlam::Compatibility judged = filter->judge(z, 2);
  const Eigen::Matrix2d S = H * filter->covariance().topLeftCorner<3, 3>() * H.transpose() + told.R;
  EXPECT_LT((judged.S - S).norm(), 1e-8 * S.norm());
  EXPECT_LT((judged.innovation - RangeBearing(0.3, -0.02)).norm(), 1e-12);
  EXPECT_NEAR(judged.nis, judged.innovation.dot(S.inverse() * judged.innovation), 1e-6 * judged.nis);
}

TEST(ReplaySlam, AnObservationWhoseCovarianceIsNoneIsInfinitelyFar) {
  ReplaySlamInputs told = inputs();
  told.anchors = {{2, told.survey_m[2]}};
  told.R = Eigen::Vector2d(0.01, -10.0).asDiagonal();
  auto filter = make_replay_slam(settings_of("ekf"), told);
  filter->reset(Pose::Zero(), start_covariance());
  filter->prepare_to_judge();
  EXPECT_EQ(filter->judge(RangeBearing(9.0, 0.0), 2).nis, std::numeric_limits<double>::infinity());
}

TEST(ReplaySlam, JacobiansAtTheTruthAreThoseOfAFilterThatIsThere) {
  // Where truth and estimate are one, looking there changes nothing; elsewhere it does.
  ReplaySlamInputs at_truth = inputs();
  at_truth.looks_at_truth = true;
  const Pose start(0.0, 0.0, 0.1);
  const auto covariance = [&](const ReplaySlamInputs& told, const Pose& first, const Pose& truth) {
    auto filter = make_replay_slam(settings_of("ekf"), told);
    filter->reset(first, start_covariance());
    filter->predict(Control(1.0, 0.0), 0.5, truth);
    return Matrix(filter->covariance());
  };
  auto plain = make_replay_slam(settings_of("ekf"), inputs());
  plain->reset(start, start_covariance());
  plain->predict(Control(1.0, 0.0), 0.5, std::nullopt);
  const Pose there = plain->pose();
  EXPECT_LT((covariance(at_truth, start, there) - plain->covariance()).norm(), 1e-9);
  EXPECT_GT((covariance(at_truth, start, there + Pose(0.0, 2.0, 0.0)) - plain->covariance()).norm(), 1e-4);
}

}  // namespace
}  // namespace credence::internal
