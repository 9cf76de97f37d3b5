#include "montecarlo/worlds/planar_slam/posterior_bound.h"

#include "core/filters/estimators/ideal_estimator.h"

namespace credence {

PosteriorBound posterior_bound(const OdometryWorld& world) {
  EstimatorSettings settings;
  settings.model = {.vehicle = world.plane.vehicle, .dt_s = world.plane.dt_s};
  settings.sensor = world.sensor;
  settings.Q = world.control_std.cwiseAbs2().asDiagonal();
  settings.R = world.measurement_std.cwiseAbs2().asDiagonal();
  settings.R /= world.detection_probability;
  settings.landmarks = world.plane.states();
  IdealEstimator filter(settings);
  filter.reset(world.path.front(), world.initial_covariance());
  PosteriorBound sum;
  const std::size_t steps = world.plane.controls.size();
  for (std::size_t k = 1; k <= steps; ++k) {
    filter.predict(world.plane.controls[k - 1], world.truth(k));
    filter.update(world.in_view[k], world.truth(k));
    sum.heading_squared += filter.covariance()(2, 2);
    sum.position_squared += filter.covariance()(0, 0) + filter.covariance()(1, 1);
  }
  const auto count = static_cast<double>(steps);
  return {sum.heading_squared / count, sum.position_squared / count};
}

}  // namespace credence
