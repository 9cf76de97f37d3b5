#include "core/filters/estimators/ukf_estimator.h"

#include <cmath>

#include "core/manifold/angle.h"

namespace credence {
namespace {

/// A ← L with L Lᵀ = A, psd, which is given by its lower triangle: the Cholesky factor, with a column of
/// zeros where a pivot is rounding.
template <class Square>
void semidefinite_root(Square& A) {
  constexpr double kLeastPivot = 1e-14;  // relative to the variance
  for (Index j = 0; j < A.cols(); ++j) {
    const double variance = A(j, j);
    for (Index k = 0; k < j; ++k) A.col(j).tail(A.rows() - j) -= A(j, k) * A.col(k).tail(A.rows() - j);
    A.col(j).head(j).setZero();
    if (A(j, j) > kLeastPivot * variance && variance > 0.0) {
      A.col(j).tail(A.rows() - j) /= std::sqrt(A(j, j));
    } else {
      A.col(j).tail(A.rows() - j).setZero();
    }
  }
}

/// D ← X with X L = D, so that X L Lᵀ Xᵀ = D Dᵀ. Where a column of L is zero that of X is free, and is left
/// to whoever has put it into D.
template <class Columns, class Square>
void divide_by_root(Columns& D, const Square& L) {
  for (Index j = L.cols() - 1; j >= 0; --j) {
    if (L(j, j) == 0.0) continue;
    for (Index k = j + 1; k < L.cols(); ++k) D.col(j) -= L(k, j) * D.col(k);
    D.col(j) /= L(j, j);
  }
}

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
  Eigen::Matrix3d L = pose_covariance();
  semidefinite_root(L);
  Eigen::Matrix2d L_q = settings().Q;
  semidefinite_root(L_q);
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
  Eigen::Matrix3d A = D.leftCols<3>();
  const Eigen::Matrix3d F = plane_motion(before.head<2>(), motion.pose.head<2>());
  for (Index j = 0; j < 3; ++j) {
    if (L(j, j) == 0.0) A.col(j) = F.col(j);  // nothing is spread there
  }
  divide_by_root(A, L);
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
  semidefinite_root(root);
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
  auto shift = shift_.resize(m);
  shift = half_sums.rowwise().sum() / c;
  nu() -= shift.col(0);
  added_covariance().noalias() = half_sums.lazyProduct(half_sums.transpose());
  added_covariance() /= c;
  added_covariance() += centre_weight(alpha) * shift.lazyProduct(shift.transpose());
  for (Index i = 0; 2 * i < m; ++i) {  // where nothing is spread
    if ((root.diagonal().array() != 0.0).all()) break;
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    plane_jacobian(pose(), landmark(seen()[static_cast<std::size_t>(3 + 2 * i)]), H_r, H_l);
    for (Index j = 0; j < s; ++j) {
      if (root(j, j) != 0.0) continue;
      const bool own = j == 3 + 2 * i || j == 4 + 2 * i;
      D.block<2, 1>(2 * i, j) = j < 3 ? Point(H_r.col(j))
                                : own ? Point(H_l.col(j - 3 - 2 * i))
                                      : Point(0.0, 0.0);
    }
  }
  divide_by_root(D, root);
  H() = D;
}

}  // namespace credence
