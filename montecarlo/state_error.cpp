#include "montecarlo/state_error.h"

#include "core/angle.h"

namespace credence {
namespace {

constexpr double kDivergedError_m = 1e4;

}  // namespace

NeesValue NeesSolver::solve(const Vector& error, const Matrix& P) {
  const Index zeros = (P.diagonal().array() == 0.0).count();
  if (zeros == 0) {
    llt_.compute(P);
    whitened_ = error;
  } else {
    std::vector<Index> kept;
    for (Index i = 0; i < P.rows(); ++i) {
      if (P(i, i) != 0.0) kept.push_back(i);
    }
    llt_.compute(P(kept, kept));
    whitened_ = error(kept);
  }
  if (llt_.info() != Eigen::Success) return {};
  llt_.matrixL().solveInPlace(whitened_);
  return {whitened_.squaredNorm(), whitened_.size()};
}

NeesValue pose_nees(const Vector& error, const Matrix& P, NeesSolver& solver) {
  const Eigen::LLT<Eigen::Matrix3d> llt(P.topLeftCorner<3, 3>());
  if (llt.info() != Eigen::Success) return solver.solve(error.head<3>(), P.topLeftCorner<3, 3>());
  const Eigen::Vector3d whitened = llt.matrixL().solve(error.head<3>());
  return {whitened.squaredNorm(), 3};
}

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
  const NeesValue whole = solver_.solve(error, P);
  const NeesValue vehicle = pose_nees(error, P, solver_);
  if (whole.dof < 0 || vehicle.dof < 0) return Outcome::not_positive_definite;
  nees = whole.value;
  dof = whole.dof;
  vehicle_nees = vehicle.value;
  return Outcome::ok;
}

}  // namespace credence
