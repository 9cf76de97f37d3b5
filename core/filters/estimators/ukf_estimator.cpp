#include "core/filters/estimators/ukf_estimator.h"

#include <cmath>

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"

namespace credence {
namespace {

/// Added to the variances that sigma points are spread by, so that a singular P has a root; m² and rad². It
/// does not enter P.
constexpr double kLeastSpread = 1e-9;

Pose pose_difference(const Pose& a, const Pose& b) {
  Pose d = a - b;
  d[2] = wrap_angle(d[2]);
  return d;
}

/// β − α², the weight of the centre's deviation.
double centre_weight(double alpha) { return 2.0 - alpha * alpha; }

}  // namespace

void UkfEstimator::propagate(const Pose& before, const Motion& motion, const Control& u, const PlanarTruth&) {
  const double alpha = settings().sigma_spread, c = 5.0 * alpha * alpha, root_c = std::sqrt(c);
  const Eigen::LLT<Eigen::Matrix3d> P_root(pose_covariance() + kLeastSpread * Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d L = P_root.matrixL();
  const Eigen::LLT<Eigen::Matrix2d> Q_root(settings().Q);
  const Eigen::Matrix2d L_q = Q_root.info() == Eigen::Success ? Eigen::Matrix2d(Q_root.matrixL())
                                                              : Eigen::Matrix2d(settings().Q.cwiseSqrt());
  Eigen::Matrix<double, 3, 5> D, half_sum;
  for (Index j = 0; j < 5; ++j) {
    Pose deviation[2];
    for (int side = 0; side < 2; ++side) {
      const double step = side == 0 ? root_c : -root_c;
      const Pose from = j < 3 ? Pose(before + step * L.col(j)) : before;
      const Control read = j < 3 ? u : Control(u + step * L_q.col(j - 3));
      deviation[side] =
          pose_difference(settings().model.vehicle.moved(from, read, settings().model.dt_s), motion.pose);
    }
    D.col(j) = (deviation[0] - deviation[1]) / (2.0 * root_c);
    half_sum.col(j) = 0.5 * (deviation[0] + deviation[1]);
  }
  const Pose shift = half_sum.rowwise().sum() / c;
  const Eigen::Matrix3d A = L.triangularView<Eigen::Lower>().solve<Eigen::OnTheRight>(D.leftCols<3>());
  propagate_pose(A, D.rightCols<2>() * D.rightCols<2>().transpose() + half_sum * half_sum.transpose() / c +
                        centre_weight(alpha) * shift * shift.transpose());
  x().head<3>() += shift;
  x()[2] = wrap_angle(x()[2]);
}

void UkfEstimator::linearise(const PlanarTruth&) {
  const auto s = static_cast<Index>(seen().size()), m = s - 3;
  const double alpha = settings().sigma_spread, c = static_cast<double>(s) * alpha * alpha;
  const double root_c = std::sqrt(c);
  auto root = root_.resize(s, s);
  root = seen_covariance();
  root.diagonal().array() += kLeastSpread;
  const Eigen::LLT<Eigen::Ref<Matrix>> llt(root);
  root.triangularView<Eigen::StrictlyUpper>().setZero();
  auto D = D_.resize(m, s);
  auto half_sums = half_sums_.resize(m, s);
  for (Index i = 0; 2 * i < m; ++i) {
    const Point l = landmark(seen()[static_cast<std::size_t>(3 + 2 * i)]);
    const Eigen::Vector2d z0 = predicted(pose(), l);
    nu().segment<2>(2 * i) = settings().sensor.innovation(seen_z()[static_cast<std::size_t>(i)], z0);
    for (Index j = 0; j < s; ++j) {
      const Pose pose_step = root_c * root.col(j).head<3>();
      const Point step = root_c * root.col(j).segment<2>(3 + 2 * i);
      const Eigen::Vector2d up = settings().sensor.innovation(predicted(pose() + pose_step, l + step), z0);
      const Eigen::Vector2d down = settings().sensor.innovation(predicted(pose() - pose_step, l - step), z0);
      D.block<2, 1>(2 * i, j) = (up - down) / (2.0 * root_c);
      half_sums.block<2, 1>(2 * i, j) = 0.5 * (up + down);
    }
  }
  const Vector shift = half_sums.rowwise().sum() / c;
  nu() -= shift;
  extra_S() = half_sums * half_sums.transpose() / c + centre_weight(alpha) * shift * shift.transpose();
  root.triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(D);
  H() = D;
}

}  // namespace credence
