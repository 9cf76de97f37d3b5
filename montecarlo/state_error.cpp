#include "montecarlo/state_error.h"

#include "core/angle.h"

namespace credence {
namespace {

constexpr double kDivergedError_m = 1e4;

/// Solves for the NEES of the states whose variance is not zero; the number of these, or −1 on failure.
Index nees_of(const Vector& error, const Matrix& P, Eigen::LLT<Matrix>& llt, Vector& whitened, double& nees) {
  const Index zeros = (P.diagonal().array() == 0.0).count();
  if (zeros == 0) {
    llt.compute(P);
    whitened = error;
  } else {
    std::vector<Index> kept;
    for (Index i = 0; i < P.rows(); ++i) {
      if (P(i, i) != 0.0) kept.push_back(i);
    }
    llt.compute(P(kept, kept));
    whitened = error(kept);
  }
  if (llt.info() != Eigen::Success) return -1;
  llt.matrixL().solveInPlace(whitened);
  nees = whitened.squaredNorm();
  return whitened.size();
}

}  // namespace

Vector true_state(const Pose& pose, std::span<const Point> landmarks, std::span<const int> order) {
  Vector x(3 + 2 * static_cast<Index>(order.size()));
  x.head<3>() = pose;
  for (std::size_t i = 0; i < order.size(); ++i) {
    x.segment<2>(3 + 2 * static_cast<Index>(i)) = landmarks[static_cast<std::size_t>(order[i])];
  }
  return x;
}

Outcome StateError::compute(const Pose& pose, std::span<const Point> landmarks, const Vector& x,
                            const Matrix& P, std::span<const int> order) {
  error.resize(x.size());
  error.head<3>() = x.head<3>() - pose;
  error[2] = wrap_angle(error[2]);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Index j = 3 + 2 * static_cast<Index>(i);
    error.segment<2>(j) = x.segment<2>(j) - landmarks[static_cast<std::size_t>(order[i])];
  }
  if (!(error.cwiseAbs().maxCoeff() < kDivergedError_m)) return Outcome::diverged;
  dof = nees_of(error, P, llt_, whitened_, nees);
  if (dof < 0) return Outcome::not_positive_definite;
  const Eigen::LLT<Eigen::Matrix3d> pose_llt(P.topLeftCorner<3, 3>());
  if (pose_llt.info() == Eigen::Success) {
    const Eigen::Vector3d pose_whitened = pose_llt.matrixL().solve(error.head<3>());
    vehicle_nees = pose_whitened.squaredNorm();
    return Outcome::ok;
  }
  const Index pose_dof = nees_of(error.head<3>(), P.topLeftCorner<3, 3>(), llt_, whitened_, vehicle_nees);
  return pose_dof < 0 ? Outcome::not_positive_definite : Outcome::ok;
}

}  // namespace credence
