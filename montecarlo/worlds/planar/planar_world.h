#pragma once

#include <numbers>
#include <vector>

#include "core/models/slam_model.h"
#include "core/models/vehicle.h"
#include "montecarlo/scenario/scenario.h"

namespace credence {

/// The planar world of a scenario: where the landmarks are and how the vehicle is to drive, without noise.
///
/// A circle has radius `path_radius` and is driven anticlockwise from (radius, 0). An eight is two such
/// circles that touch in the origin, where it starts. A line is driven from x = −radius forth to +radius and
/// in reverse gear back. Landmarks stand alternately inside and outside the path at equal spacing along it,
/// the first of them, near the start, are the anchors.
struct PlanarWorld {
  Vehicle vehicle;
  double dt_s = 0.25;
  double sensor_min_range_m = 0.0;
  double sensor_range_m = 30.0;
  double half_field_of_view_rad = std::numbers::pi;
  Pose start = Pose::Zero();
  std::vector<Point> landmarks;   ///< number i is landmarks[i]; states first, then anchors
  Index anchors = 0;              ///< how many at the end are anchors
  std::vector<Control> controls;  ///< nominal, of steps 1 … T

  Index states() const { return static_cast<Index>(landmarks.size()) - anchors; }

  /// Whether the sensor sees what is at z: within range and field of view.
  bool sees(const RangeBearing& z) const;
};

/// Throws std::invalid_argument for a vehicle that cannot turn as tightly as the path asks.
PlanarWorld make_planar_world(const Scenario& scenario);

}  // namespace credence
