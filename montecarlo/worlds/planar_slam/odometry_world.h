#pragma once

#include <memory>
#include <string_view>

#include "core/filters/estimators/slam_estimator.h"
#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "montecarlo/worlds/planar/planar_world.h"

namespace credence::internal {

/// A vehicle that drives a circle exactly, its odometry and its sensor of landmarks noisy: the world of the
/// consistency tables ([Huang 2010], [Brossard 2020]).
///
/// Landmarks stand at equal angles on a ring about the circle's centre, or are drawn evenly over an annulus
/// around the circle: a function of world.map alone, whatever the seed of the study.
struct OdometryWorld {
  PlanarWorld plane;       ///< vehicle, path, landmarks (all of them states), field of view
  std::vector<Pose> path;  ///< true poses of steps 0 … T
  LandmarkSensor sensor;
  /// What the sensor says without noise at steps 0 … T, as the vehicle never leaves its path.
  std::vector<std::vector<Observation<PlanarModel>>> in_view;
  PlanarNoise noise;     ///< of the control that is read, and of what `sensor` measures, m and m or rad
  double width_m = 0.0;  ///< an error above this is divergence: the landmarks' spread

  PlanarTruth truth(std::size_t k) const { return {path[k > 0 ? k - 1 : 0], path[k], plane.landmarks}; }
};

/// What world.landmark_layout and world.landmark_sensor ask for.
bool has_landmark_ring(const Scenario& scenario);
bool measures_relative_position(const Scenario& scenario);

/// Throws std::invalid_argument as make_planar_world does.
OdometryWorld make_odometry_world(const Scenario& scenario);

/// What the estimators of this scenario are told.
EstimatorSettings estimator_settings(const Scenario& scenario, const OdometryWorld& world);

/// The estimator of filter.estimator, or another one.
std::unique_ptr<SlamEstimator> scenario_estimator(const Scenario& scenario, const OdometryWorld& world);
std::unique_ptr<SlamEstimator> scenario_estimator(const Scenario& scenario, const OdometryWorld& world,
                                                  std::string_view name);

}  // namespace credence::internal
