#include "montecarlo/worlds/planar_slam/odometry_bound.h"

#include "core/filters/estimators/ideal_estimator.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {

PosteriorBound odometry_bound(const OdometryWorld& world) {
  EstimatorSettings settings;
  settings.model = {.vehicle = world.plane.vehicle, .dt_s = world.plane.dt_s};
  settings.sensor = world.sensor;
  settings.Q = world.noise.control_std.cwiseAbs2().asDiagonal();
  settings.R = world.noise.measurement_std.cwiseAbs2().asDiagonal();
  settings.R /= world.noise.detection_probability;
  settings.landmarks = world.plane.states();
  IdealEstimator filter(settings);
  filter.reset(world.path.front(), world.noise.initial_covariance());
  const RunLayout layout = planar_layout(world.plane);
  BoundRecorder recorder(layout, 1);
  Vector variances(std::ssize(layout.states));
  for (std::size_t k = 1; k <= world.plane.controls.size(); ++k) {
    stop_point();
    filter.predict(world.plane.controls[k - 1], world.truth(k));
    if (!filter.update(world.in_view[k], world.truth(k)).ok) return {.reason = kBoundOfNoisyMeasurements};
    variances.setConstant(kNaN);
    variances.head<3>() = filter.covariance().diagonal().head<3>();
    for (const int landmark : filter.landmarks()) {
      variances.segment<2>(3 + 2 * Index{landmark}) =
          filter.covariance().diagonal().segment<2>(filter.offset_of(landmark));
    }
    recorder.add(variances, variances);
  }
  return recorder.take();
}

}  // namespace credence::internal
