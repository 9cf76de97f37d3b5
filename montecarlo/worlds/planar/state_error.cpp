#include "montecarlo/worlds/planar/state_error.h"

#include "core/manifold/angle.h"

namespace credence::internal {

Vector true_state(const Pose& pose, std::span<const Point> landmarks, std::span<const int> order) {
  Vector x(3 + 2 * static_cast<Index>(order.size()));
  x.head<3>() = pose;
  for (std::size_t i = 0; i < order.size(); ++i) {
    x.segment<2>(3 + 2 * static_cast<Index>(i)) = landmarks[static_cast<std::size_t>(order[i])];
  }
  return x;
}

bool StateError::set_error(const Pose& pose, std::span<const Point> landmarks, const Vector& x,
                           std::span<const int> order) {
  error.resize(x.size());
  error.head<3>() = x.head<3>() - pose;
  error[2] = wrap_angle(error[2]);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Index j = 3 + 2 * static_cast<Index>(i);
    error.segment<2>(j) = x.segment<2>(j) - landmarks[static_cast<std::size_t>(order[i])];
  }
  return error.cwiseAbs().maxCoeff() < kDivergedError_m;
}

void StateError::put_into(PlanarStep& step) const {
  step.nees = nees;
  step.nees_dof = dof;
  step.vehicle_nees = vehicle_nees;
  step.position_error_squared = error.head<2>().squaredNorm();
  step.heading_error_squared = error[2] * error[2];
  step.map_error_squared = error.tail(error.size() - 3).squaredNorm();
  step.landmarks = (error.size() - 3) / 2;
}

Outcome StateError::set_nees(const NeesValue& whole, const NeesValue& vehicle) {
  if (whole.dof < 0 || vehicle.dof < 0) return Outcome::not_positive_definite;
  nees = whole.value;
  dof = whole.dof;
  vehicle_nees = vehicle.value;
  return Outcome::ok;
}

}  // namespace credence::internal
