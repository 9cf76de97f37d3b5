#include "montecarlo/worlds/planar/planar_step.h"

namespace credence::internal {

void PlanarStep::add_to(StepStatistics& s, RunTotals& sums) const {
  sums.whole.add(nees, nees_dof);
  sums.vehicle.add(vehicle_nees, vehicle_dof);
  sums.not_converged += update.converged ? 0 : 1;
  s[Quantity::nees].add(nees);
  s.nees_dof += nees_dof;
  if (update.dof > 0) s[Quantity::nis].add(update.nis);
  s.nis_dof += update.dof;
  if (vehicle_dof > 0) s[Quantity::vehicle_nees].add(vehicle_nees);
  s[Quantity::trace_prior].add(update.trace_prior);
  s[Quantity::trace].add(traces.all);
  s[Quantity::trace_vehicle].add(traces.position);
  s[Quantity::trace_landmarks].add(traces.landmarks);
  s[Quantity::position_error_squared].add(position_error_squared);
  s[Quantity::heading_error_squared].add(heading_error_squared);
  s[Quantity::heading_variance].add(traces.heading);
  if (landmarks > 0) {
    const auto count = static_cast<double>(landmarks);
    s[Quantity::landmark_error_squared].add(map_error_squared / count);
    s[Quantity::landmark_variance].add(traces.landmarks / count);
  }
}

}  // namespace credence::internal
