#pragma once

#include <Eigen/Core>

namespace credence::internal {

/// A point of the earth in Cartesian coordinates that turn with it, m.
///
/// geodetic: latitude (rad), longitude (rad), height above the ellipsoid (m) of WGS 84.
Eigen::Vector3d earth_fixed(const Eigen::Vector3d& geodetic);

/// Latitude (rad), longitude (rad) and height (m) of such a point ([Bowring 1976], one step: below 1e-9 rad
/// up to 10 km of height).
Eigen::Vector3d geodetic(const Eigen::Vector3d& earth_fixed);

/// The rotation from earth-fixed axes to east, north, up at a place (latitude, longitude, height).
Eigen::Matrix3d east_north_up(const Eigen::Vector3d& geodetic);

}  // namespace credence::internal
