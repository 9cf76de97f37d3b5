#include "montecarlo/worlds/spatial_slam/spatial_bound.h"

#include "core/stop_point.h"

namespace credence::internal {

PosteriorBound spatial_bound(const SpatialWorld& world) {
  SpatialSlam filter(spatial_kind("ideal"), std::ssize(world.landmarks));
  filter.reset(world.path.front(), world.initial_covariance());
  BoundRecorder recorder(spatial_layout(world), 1);
  std::vector<SpatialObservation> observations;
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    stop_point();
    observations.clear();
    for (const SpatialWorld::Exact& exact : world.in_view[k]) {
      observations.push_back(
          {exact.landmark, exact.z, world.landmark_variances(exact.z) / world.detection_probability});
    }
    filter.predict(world.controls[k - 1], world.truth(k));
    filter.update(observations, world.truth(k));
    const Vector variances = filter.pose_covariance().diagonal();
    recorder.add(variances, variances);
  }
  return recorder.take();
}

}  // namespace credence::internal
