#include "core/filters/spatial/spatial_slam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/chart.h"

namespace credence::internal {
namespace {

using Six = Eigen::Matrix<double, 6, 1>;

struct Draws {
  std::mt19937_64 bits{11};
  std::normal_distribution<double> normal;
  Eigen::Vector3d three(double scale) {
    return Eigen::Vector3d::NullaryExpr([&] { return scale * normal(bits); });
  }
};

/// A vehicle among five landmarks for some steps, its odometry and sensor off by `noise`.
struct Drive {
  explicit Drive(double noise) {
    Draws draws;
    for (int i = 0; i < 5; ++i) landmarks.push_back(draws.three(4.0));
    path.emplace_back(SO3::Exp(draws.three(0.5)), draws.three(1.0));
    for (int k = 0; k < 12; ++k) {
      SpatialControl control{draws.three(0.5), draws.three(0.2), Six::Constant(1e-4)};
      path.push_back(path.back() * SE3(SO3::Exp(control.omega), control.v));
      control.v += noise * draws.three(1.0);
      control.omega += noise * draws.three(1.0);
      controls.push_back(control);
      std::vector<SpatialObservation> observations;
      for (int i = k % 2; i < 5; ++i) {  // not all at the first step
        const SE3 back = path.back().inverse();
        const Eigen::Vector3d z =
            back.rotation() * landmarks[static_cast<std::size_t>(i)] + back.translation();
        observations.push_back({i, z + noise * draws.three(1.0), Eigen::Vector3d::Constant(4e-4)});
      }
      seen.push_back(observations);
    }
  }
  SpatialTruth truth(std::size_t k) const { return {path[k - 1], path[k], landmarks}; }
  SpatialSlam play(const char* name, std::size_t steps = 12) const {
    SpatialSlam filter(spatial_kind(name), 5);
    filter.reset(path.front(), SpatialSlam::PoseMatrix(1e-4 * SpatialSlam::PoseMatrix::Identity()));
    for (std::size_t k = 1; k <= steps; ++k) {
      filter.predict(controls[k - 1], truth(k));
      EXPECT_TRUE(filter.update(seen[k - 1], truth(k)));
    }
    return filter;
  }

  std::vector<Eigen::Vector3d> landmarks;
  std::vector<SE3> path;
  std::vector<SpatialControl> controls;
  std::vector<std::vector<SpatialObservation>> seen;
};

// Without noise every estimator stays at the truth, where all have the same Jacobians: one P for all.
TEST(SpatialSlam, AtTheTruthAllEstimatorsAreOne) {
  const Drive drive(0.0);
  const SpatialSlam ekf = drive.play("ekf");
  const Matrix P = ekf.covariance().selfadjointView<Eigen::Lower>();
  for (const SpatialKind& kind : spatial_kinds()) {
    const SpatialSlam filter = drive.play(kind.name.data());
    EXPECT_LT(filter.pose_error(drive.path.back(), true).norm(), 1e-12) << kind.name;
    const Matrix other = filter.covariance().selfadjointView<Eigen::Lower>();
    EXPECT_LT((other - P).norm(), 1e-12 * P.norm()) << kind.name;
    EXPECT_LT(filter.map_error(drive.truth(12)).error.norm(), 1e-11) << kind.name;
  }
}

// The right-invariant filter with dense matrices in its own chart, where Φ = I, H = R̂ᵀ [−I, 0, I] and P keeps
// its numbers through a correction: the same numbers.
TEST(SpatialSlam, TheInvariantFilterIsThatOfItsOwnChart) {
  const Drive drive(0.03);
  const SpatialSlam filter = drive.play("invariant");
  SE3 pose = drive.path.front();
  std::vector<Eigen::Vector3d> l;
  std::vector<int> order;
  const auto about = [&](const Eigen::Vector3d& x) {  // ξ = δ + x̂^ φ of the pose
    SpatialSlam::PoseMatrix T = SpatialSlam::PoseMatrix::Identity();
    T.topRightCorner<3, 3>() = cross_matrix(x);
    return T;
  };
  Matrix P = about(pose.translation()) * 1e-4 * about(pose.translation()).transpose();
  for (std::size_t k = 1; k <= 12; ++k) {
    const SpatialControl& u = drive.controls[k - 1];
    const SE3 before = pose;
    pose = pose * SE3(SO3::Exp(u.omega), u.v);
    Eigen::Matrix<double, 6, 6> G;  // noise as Exp(ξ) of pose; its turn moves the landmarks' ξ, too
    G << before.rotation().matrix(),
        cross_matrix(pose.translation()) * pose.rotation().matrix() * right_jacobian<SO3>(u.omega),
        Eigen::Matrix3d::Zero(), pose.rotation().matrix() * right_jacobian<SO3>(u.omega);
    Matrix all = Matrix::Zero(P.rows(), 6);
    all.topRows<6>() = G;
    for (std::size_t i = 0; i < l.size(); ++i) {
      all.block<3, 3>(6 + 3 * static_cast<Index>(i), 3) = cross_matrix(l[i]) * G.bottomRightCorner<3, 3>();
    }
    P += all * u.variances.asDiagonal() * all.transpose();
    std::vector<SpatialObservation> known, fresh;
    for (const SpatialObservation& s : drive.seen[k - 1]) {
      (std::ranges::find(order, s.landmark) == order.end() ? fresh : known).push_back(s);
    }
    const Index m = 3 * std::ssize(known);
    Matrix H = Matrix::Zero(m, P.rows());
    Vector nu(m);
    const Eigen::Matrix3d Rt = pose.rotation().matrix().transpose();
    for (Index r = 0; r < std::ssize(known); ++r) {
      const auto& s = known[static_cast<std::size_t>(r)];
      const Index at = std::ranges::find(order, s.landmark) - order.begin();
      H.block<3, 3>(3 * r, 0) = -Rt;
      H.block<3, 3>(3 * r, 6 + 3 * at) = Rt;
      nu.segment<3>(3 * r) = s.z - Rt * (l[static_cast<std::size_t>(at)] - pose.translation());
    }
    if (m > 0) {
      const Matrix S = H * P * H.transpose() + 4e-4 * Matrix::Identity(m, m);
      const Matrix K = S.llt().solve(H * P).transpose();
      const Vector xi = K * nu;
      P -= K * S * K.transpose();
      const SO3 turn = SO3::Exp(xi.segment<3>(3));
      const Eigen::Matrix3d V = SO3::left_jacobian(xi.segment<3>(3));
      pose = SE3(turn * pose.rotation(), turn * pose.translation() + V * xi.head<3>());
      for (std::size_t i = 0; i < l.size(); ++i) {
        l[i] = turn * l[i] + V * xi.segment<3>(6 + 3 * static_cast<Index>(i));
      }
    }
    for (const SpatialObservation& s : fresh) {  // ξ_l = ξ_p + R̂ w
      const Index at = P.rows();
      Matrix J = Matrix::Zero(at + 3, at);
      J.topRows(at).setIdentity();
      J.block<3, 3>(at, 0).setIdentity();
      Matrix grown = J * P * J.transpose();
      grown.bottomRightCorner<3, 3>() += 4e-4 * Eigen::Matrix3d::Identity();
      P = grown;
      l.emplace_back(pose.translation() + pose.rotation() * s.z);
      order.push_back(s.landmark);
    }
  }
  ASSERT_EQ(P.rows(), 21);
  EXPECT_LT((filter.pose().translation() - pose.translation()).norm(), 1e-10);
  EXPECT_LT((filter.own_pose_covariance() - P.topLeftCorner<6, 6>()).norm(), 1e-10 * P.norm());
  const Matrix of_map = filter.map_error(drive.truth(12)).P.selfadjointView<Eigen::Lower>();
  EXPECT_LT((of_map - P.bottomRightCorner(15, 15)).norm(), 1e-10 * P.norm());
  // The plain filter is another.
  EXPECT_GT((drive.play("ekf").pose().translation() - pose.translation()).norm(), 1e-6);
}

TEST(SpatialSlam, UnknownNamesAreRefused) { EXPECT_THROW(spatial_kind("magic"), std::invalid_argument); }

}  // namespace
}  // namespace credence::internal
