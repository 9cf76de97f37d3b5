#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence {

NeesValue NeesSolver::solve(const VectorRef& error, const MatrixRef& P) {
  const Index zeros = (P.diagonal().array() == 0.0).count();
  if (zeros == 0) {
    llt_.compute(P);
    whitened_ = error;
  } else {
    kept_.clear();
    for (Index i = 0; i < P.rows(); ++i) {
      if (P(i, i) != 0.0) kept_.push_back(i);
    }
    P_kept_ = P(kept_, kept_);
    llt_.compute(P_kept_);
    whitened_ = error(kept_);
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

PlanarTraces planar_traces(const Matrix& P) {
  PlanarTraces traces{.all = P.trace(), .position = P(0, 0) + P(1, 1)};
  traces.landmarks = traces.all - traces.position - P(2, 2);
  return traces;
}

}  // namespace credence
