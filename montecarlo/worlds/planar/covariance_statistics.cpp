#include "montecarlo/worlds/planar/covariance_statistics.h"

#include <cmath>

#include "core/linear_algebra/cholesky.h"

namespace credence {

NeesValue pose_nees(const Vector& error, const Matrix& P, NeesSolver& solver) {
  const Eigen::LLT<Eigen::Matrix3d> llt(P.topLeftCorner<3, 3>());
  const Eigen::Vector3d whitened = llt.matrixL().solve(error.head<3>());
  const double value = whitened.squaredNorm();
  if (llt.info() != Eigen::Success || !std::isfinite(value))
    return solver.solve(error.head<3>(), P.topLeftCorner<3, 3>());
  return {value, 3};
}

PlanarTraces planar_traces(const Matrix& P) { return planar_traces(P.trace(), P.topLeftCorner<3, 3>()); }

PlanarTraces planar_traces(double trace, const Eigen::Matrix3d& pose) {
  PlanarTraces traces{.all = trace, .position = pose(0, 0) + pose(1, 1), .heading = pose(2, 2)};
  traces.landmarks = traces.all - traces.position - traces.heading;
  return traces;
}

}  // namespace credence
