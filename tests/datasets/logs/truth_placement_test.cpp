#include "datasets/logs/truth_placement.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "core/manifold/sek3.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr Index kPose = 6;

/// A body that drives about at 1 m a row, turning by `turn` rad, and what odometry knows of it: errors in
/// fixed axes that grow from those of a start known to `start` m and rad.
struct Odometry {
  Odometry(std::uint64_t seed, int rows, double start) : random_(seed) {
    estimate.axes = kFixedAxes;
    PoseCovariance Q = PoseCovariance::Zero();
    Q.diagonal() << 4e-6, 4e-6, 4e-6, 25e-8, 25e-8, 25e-8;
    PoseCovariance P = start * start * PoseCovariance::Identity();
    PoseError e = start * normals();
    Vector3d p = Vector3d::Zero();
    double yaw = 0.0;
    for (int k = 0; k < rows; ++k) {
      if (k > 0) {
        const Vector3d moves(std::cos(yaw), std::sin(yaw), 0.2 * std::sin(0.1 * k));
        PoseCovariance F = PoseCovariance::Identity();
        F.topRightCorner<3, 3>() = -cross_matrix(moves);
        e = F * e + PoseError(Q.diagonal().cwiseSqrt().cwiseProduct(normals()));
        P = F * P * F.transpose() + Q;
        p += moves;
        yaw += 0.05 * std::sin(0.07 * k) + 0.03;
      }
      const Eigen::Quaterniond R(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
      truth.time_s.push_back(k);
      truth.poses.push_back({p, R});
      estimate.time_s.push_back(k);
      estimate.lines.push_back(k + 1);
      estimate.poses.push_back({p + e.head<3>(), SO3::Exp(e.tail<3>()).quaternion() * R});
      estimate.covariances.push_back(P);
    }
  }

  /// Moves the frame of the truth.
  void turn_truth(const Eigen::Isometry3d& by) {
    for (SpatialPose& pose : truth.poses)
      pose = {by * pose.position, Eigen::Quaterniond(by.linear()) * pose.orientation};
  }
  TruthPlacement placed(TruthAlignment alignment) const {
    const TrajectoryMatching matching{.alignment = alignment};
    return place_truth(pose_samples(estimate, matching), truth, matching, estimate.axes, true);
  }

  Trajectory estimate, truth;

 private:
  PoseError normals() {
    return PoseError::NullaryExpr([this] { return normal_(random_); });
  }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

Eigen::Isometry3d far_away(bool tilted) {
  return Eigen::Translation3d(30.0, -20.0, 5.0) * Eigen::AngleAxisd(2.0, Vector3d::UnitZ()) *
         Eigen::AngleAxisd(tilted ? 0.4 : 0.0, Vector3d::UnitX()) * Eigen::Isometry3d::Identity();
}

double sum_of_nees(const Odometry& log, const Eigen::Isometry3d& motion) {
  TruthPlacement placement;
  placement.motion = motion;
  const TruthComparison comparison(log.truth, {}, log.estimate.axes, true, placement);
  double sum = 0.0;
  Step step;
  for (const EstimateSample& sample : pose_samples(log.estimate, {.alignment = TruthAlignment::se3})) {
    comparison.compare(sample.estimate, *comparison.truth_at(sample.estimate.time_s), sample.kept, step);
    sum += step.error.dot(step.P.llt().solve(step.error));
  }
  return sum;
}

TEST(TruthPlacement, NoMotionNearTheFittedOneHasASmallerSumOfNees) {
  for (const bool tilted : {false, true}) {
    Odometry log(3, 60, 0.01);
    log.turn_truth(far_away(tilted));
    const TrajectoryMatching matching{.alignment = tilted ? TruthAlignment::se3 : TruthAlignment::yaw};
    const Eigen::Isometry3d best =
        fitted_motion(pose_samples(log.estimate, matching), log.truth, matching, kFixedAxes, true);
    const double least = sum_of_nees(log, best);
    EXPECT_LE(least, sum_of_nees(log, far_away(tilted).inverse())) << "the right place";
    for (int axis = 0; axis < 3; ++axis) {
      for (const double by : {-1e-4, 1e-4}) {
        const Vector3d unit = Vector3d::Unit(axis);
        EXPECT_GT(sum_of_nees(log, Eigen::Translation3d(by * unit) * best), least);
        if (tilted || axis == 2) EXPECT_GT(sum_of_nees(log, best * Eigen::AngleAxisd(by, unit)), least);
      }
    }
  }
}

// The frame has the error of the first pose, and a start known exactly is no exception.
TEST(TruthPlacement, APoseThatIsKnownBestHoldsTheFrame) {
  for (const double start : {0.0, 1e-5}) {
    Odometry log(5, 80, start);
    log.turn_truth(far_away(false));
    const TruthPlacement placement = log.placed(TruthAlignment::yaw);
    EXPECT_FALSE(placement.by_all);
    EXPECT_EQ(placement.time_s, 0.0);
    const SpatialPose first = log.truth.poses[0];
    EXPECT_LT((placement.motion * first.position - log.estimate.poses[0].position).norm(), 1e-9);
    const TrajectoryErrors errors =
        trajectory_errors(log.estimate, log.truth, {.alignment = TruthAlignment::yaw});
    EXPECT_EQ(errors.used_up, 1);
    EXPECT_EQ(errors.rows.size(), 79U);
    testing::RecordedSink sink;
    tell_placement(errors.placement, errors.used_up, sink);
    EXPECT_THAT(sink.said(), HasSubstr("1 row of which it is more was left out"));
    EXPECT_EQ(sink.fit, TruthFit::none);
  }
}

TEST(TruthPlacement, WithoutSuchAPoseAllErrorsPlaceIt) {
  Odometry log(5, 80, 0.05);
  log.turn_truth(far_away(false));
  Odometry points = log;
  points.truth.has_orientation = false;  // of which one tells no heading
  for (SpatialPose& pose : points.truth.poses) pose.orientation.setIdentity();
  for (const Odometry& each : {log, points}) {
    const TruthPlacement placement = each.placed(TruthAlignment::yaw);
    EXPECT_TRUE(placement.by_all);
    testing::RecordedSink sink;
    tell_placement(placement, 0, sink);
    EXPECT_EQ(sink.fit, TruthFit::least_nees);
    EXPECT_THAT(sink.said(), HasSubstr("never pessimistic"));
  }
}

// As of a filter of positions alone, whose poses have no variance of orientation in any row.
TEST(TruthPlacement, StatesWithoutAnyVarianceDoNotPlaceIt) {
  Odometry log(5, 80, 0.01);
  log.turn_truth(far_away(false));
  for (PoseCovariance& P : log.estimate.covariances) {
    P.bottomRows<3>().setZero();
    P.rightCols<3>().setZero();
  }
  EXPECT_LT((log.placed(TruthAlignment::yaw).motion.matrix() - far_away(false).inverse().matrix()).norm(),
            1.0);
}

TEST(TruthPlacement, FindsTheMotionOfEveryKind) {
  Odometry exact(1, 30, 0.05);
  exact.estimate.poses = exact.truth.poses;
  for (const auto alignment : {TruthAlignment::yaw, TruthAlignment::se3}) {
    Odometry log = exact;
    const Eigen::Isometry3d by = far_away(alignment == TruthAlignment::se3);
    log.turn_truth(by);
    EXPECT_LT((log.placed(alignment).motion.matrix() - by.inverse().matrix()).norm(), 1e-9);
  }
  Odometry plane = exact;
  plane.turn_truth(far_away(false));
  plane.estimate.axes = {.orientation = OrientationError::planar};
  const Eigen::Isometry3d found = plane.placed(TruthAlignment::se2).motion;
  EXPECT_LT((found.linear() - far_away(false).linear().transpose()).norm(), 1e-9);
  EXPECT_EQ(found.translation().z(), 0.0) << "the height stays";
}

// Of exact odometry the mean NEES of the whole stays six, and that of the second row as well, whose P is
// tiny.
TEST(TruthPlacement, OdometryThatIsRightStaysRight) {
  constexpr int kLogs = 400;
  double mean = 0.0, square = 0.0, second = 0.0;
  for (int i = 0; i < kLogs; ++i) {
    Odometry log(static_cast<std::uint64_t>(i) + 1, 50, 1e-5);
    log.turn_truth(far_away(false));
    const TrajectoryErrors errors =
        trajectory_errors(log.estimate, log.truth, {.alignment = TruthAlignment::yaw});
    double sum = 0.0;
    for (const Step& row : errors.rows) sum += row.error.dot(row.P.llt().solve(row.error));
    const double average = sum / static_cast<double>(errors.rows.size());
    mean += average / kLogs;
    square += average * average / kLogs;
    const Step& row = errors.rows.front();
    second += row.error.dot(row.P.llt().solve(row.error)) / kLogs;
  }
  const double n = static_cast<double>(kPose);
  EXPECT_NEAR(mean, n, 5.0 * std::sqrt((square - mean * mean) / kLogs));
  EXPECT_NEAR(second, n, 5.0 * std::sqrt(2.0 * n / kLogs));
}

}  // namespace
}  // namespace credence::internal
