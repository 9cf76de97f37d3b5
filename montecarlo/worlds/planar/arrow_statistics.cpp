#include "montecarlo/worlds/planar/arrow_statistics.h"

namespace credence::internal {

NeesValue joint_nees(const Vector& error, const ArrowCovariance& P, NeesSolver&) {
  const ArrowNees nees = arrow_nees(error, P);
  if (!nees.positive_definite) return {};
  return {nees.nees, nees.dof};
}

NeesValue pose_nees(const Vector& error, const ArrowCovariance& P, NeesSolver& solver) {
  return solver.solve(error.head<3>(), P.vehicle());
}

PlanarTraces planar_traces(const ArrowCovariance& P) {
  PlanarTraces traces{
      .position = P.variance(0) + P.variance(1), .heading = P.variance(2), .landmarks = P.trace_of_map()};
  traces.all = traces.position + traces.heading + traces.landmarks;
  return traces;
}

}  // namespace credence::internal
