#include "datasets/logs/conventions/pose_error.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "core/manifold/sek3.h"
#include "datasets/logs/conventions/pose_chart.h"

namespace credence::internal {
namespace {

PoseError random_vector(std::mt19937_64& random, double size) {
  std::normal_distribution<double> normal;
  PoseError v;
  for (double& x : v) x = size * normal(random);
  return v;
}

SpatialPose moved(const SpatialPose& pose, const PoseError& xi) {
  const SE3 T = SE3(SO3(pose.orientation), pose.position) * SE3::Exp(xi);
  return {T.translation(), T.rotation().quaternion()};
}

/// Every chart beside the planar one, which has the axes of rpy.
std::vector<PoseChart> spatial_charts() {
  std::vector<PoseChart> charts;
  for (const PoseChart& chart : pose_charts()) {
    if (chart.axes.orientation != OrientationError::planar) charts.push_back(chart);
  }
  return charts;
}

TEST(PoseError, OfAKnownPairOfPoses) {
  // The estimate is 1 m east of the truth and turned by 0.2 rad about the world's z; the truth looks along x
  // after a quarter turn about x.
  const SpatialPose truth{Eigen::Vector3d(1, 2, 3),
                          Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()))};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  const SpatialPose estimate{truth.position + Eigen::Vector3d::UnitX(), turn * truth.orientation};
  const auto error = [&](std::string_view name) {
    return pose_error(estimate, truth, pose_chart_named(name).axes);
  };
  const auto near = [](const PoseError& got, std::initializer_list<double> want) {
    EXPECT_TRUE(got.isApprox(Eigen::Map<const PoseError>(want.begin()), 1e-12)) << got.transpose();
  };
  near(error("ros"), {1, 0, 0, 0, 0, 0.2});
  near(error("body"), {1, 0, 0, 0, 0.2, 0});  // the body's y is the world's z
  near(error("ceres"), {1, 0, 0, 0, 0, 0.1});
  near(error("g2o"), {std::cos(0.2), 0, std::sin(0.2), 0, std::sin(0.1), 0});
  // On SE(3) the translation of T̂ T⁻¹ is p̂ − Exp(0.2 z) p, of which V⁻¹ is taken.
  const Eigen::Vector3d phi(0, 0, 0.2);
  PoseError left;
  left << SO3::left_jacobian_inverse(phi) * (estimate.position - turn * truth.position), phi;
  EXPECT_TRUE(error("left").isApprox(left, 1e-12));
}

TEST(PoseError, AnExponentialIsItsOwnErrorInTheChartOfTheGroup) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const SpatialPose truth = moved({}, random_vector(random, 1.0));
    const PoseError xi = random_vector(random, 0.5);
    EXPECT_TRUE(pose_error(moved(truth, xi), truth, pose_chart_named("sophus").axes).isApprox(xi, 1e-9));
  }
}

TEST(PoseError, JacobianIsThatOfDifferences) {
  std::mt19937_64 random(2);
  for (const PoseChart& chart : spatial_charts()) {
    for (int i = 0; i < 10; ++i) {
      SpatialPose truth = moved({}, random_vector(random, 0.4));
      const SpatialPose estimate = moved(truth, random_vector(random, 0.3));
      const PoseCovariance D = pose_error_jacobian(estimate, truth, chart.axes);
      constexpr double kStep = 1e-6;
      for (Index c = 0; c < 6; ++c) {
        const PoseError step = kStep * PoseError::Unit(c);
        const PoseError slope = (pose_error(estimate, moved(truth, step), chart.axes) -
                                 pose_error(estimate, moved(truth, -step), chart.axes)) /
                                (2.0 * kStep);
        EXPECT_LT((slope - D.col(c)).norm(), 1e-8) << chart.name << " column " << c;
      }
    }
  }
}

// J of errors about T A by errors about T, from differences of both.
TEST(PoseError, CovarianceGoesAlongWhereTheFrameMovesOnTheBody) {
  std::mt19937_64 random(4);
  for (const PoseChart& chart : spatial_charts()) {
    const SpatialPose pose = moved({}, random_vector(random, 0.5)), A = moved({}, random_vector(random, 0.7));
    const auto on_body = [&](const SpatialPose& p) {
      return SpatialPose{p.position + p.orientation * A.position, p.orientation * A.orientation};
    };
    constexpr double kStep = 1e-6;
    PoseCovariance at_pose, at_other;
    for (Index c = 0; c < 6; ++c) {
      const SpatialPose before = moved(pose, -kStep * PoseError::Unit(c));
      const SpatialPose behind = moved(pose, kStep * PoseError::Unit(c));
      at_pose.col(c) =
          (pose_error(pose, behind, chart.axes) - pose_error(pose, before, chart.axes)) / (2.0 * kStep);
      at_other.col(c) = (pose_error(on_body(pose), on_body(behind), chart.axes) -
                         pose_error(on_body(pose), on_body(before), chart.axes)) /
                        (2.0 * kStep);
    }
    const PoseCovariance J = at_other * at_pose.inverse();
    const PoseCovariance P = PoseError::LinSpaced(1.0, 2.0).asDiagonal();
    SpatialPose other = pose;
    PoseCovariance carried = P;
    move_on_body(A, chart.axes, other, carried);
    EXPECT_LT((carried - J * P * J.transpose()).norm(), 1e-6) << chart.name;
    EXPECT_LT((other.position - on_body(pose).position).norm(), 1e-12);
    move_on_body(inverse(A), chart.axes, other, carried);
    EXPECT_LT((carried - P).norm(), 1e-9) << chart.name;
  }
}

TEST(PoseError, CovarianceCarriedOverAndBackIsTheSame) {
  std::mt19937_64 random(3);
  const SpatialPose pose = moved({}, random_vector(random, 0.5));
  PoseCovariance A;
  for (Index c = 0; c < 6; ++c) A.col(c) = random_vector(random, 1.0);
  const PoseCovariance P = A * A.transpose();
  for (const PoseChart& from : spatial_charts()) {
    for (const PoseChart& to : spatial_charts()) {
      const PoseCovariance there = transported(P, pose, from.axes, to.axes);
      EXPECT_TRUE(transported(there, pose, to.axes, from.axes).isApprox(P, 1e-9)) << from.name << to.name;
    }
  }
  // Between right and left the change is the adjoint.
  const PoseCovariance Ad = SE3(SO3(pose.orientation), pose.position).adjoint();
  EXPECT_TRUE(transported(P, pose, pose_chart_named("sophus").axes, pose_chart_named("left").axes)
                  .isApprox(Ad * P * Ad.transpose(), 1e-9));
}

TEST(PoseChart, HalfAnglesAreAQuarterOfTheVariance) {
  const PoseCovariance P = PoseCovariance::Identity();
  const PoseCovariance half = transported(P, {}, kFixedAxes, pose_chart_named("ceres").axes);
  EXPECT_NEAR(half(3, 3), 0.25, 1e-12);
  EXPECT_NEAR(half(0, 0), 1.0, 1e-12);
}

TEST(PoseChart, TheRotationFirstIsMovedBehindThePosition) {
  PoseCovariance written = PoseCovariance::Zero();
  written(0, 0) = 1.0;  // rotation about x
  written(0, 4) = 2.0;  // with position y
  const PoseCovariance P = pose_chart_named("gtsam").position_first(written);
  EXPECT_EQ(P(3, 3), 1.0);
  EXPECT_EQ(P(3, 1), 2.0);
  EXPECT_EQ(pose_chart_named("sophus").position_first(written), written);
}

TEST(PoseChart, AnUnknownNameIsToldWithAllThatAreAccepted) {
  EXPECT_THAT([] { pose_chart_named("gtsma"); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::AllOf(
                  ::testing::HasSubstr("--chart gtsma: accepted are ros"), ::testing::HasSubstr("ceres"))));
}

}  // namespace
}  // namespace credence::internal
