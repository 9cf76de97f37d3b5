#include "datasets/logs/geodesy.h"

#include <cmath>

namespace credence::internal {
namespace {

// WGS 84.
constexpr double kEquator_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);

}  // namespace

Eigen::Vector3d earth_fixed(const Eigen::Vector3d& place) {
  const double sine = std::sin(place.x()), cosine = std::cos(place.x());
  const double normal = kEquator_m / std::sqrt(1.0 - kEccentricity2 * sine * sine);
  return {(normal + place.z()) * cosine * std::cos(place.y()),
          (normal + place.z()) * cosine * std::sin(place.y()),
          (normal * (1.0 - kEccentricity2) + place.z()) * sine};
}

Eigen::Vector3d geodetic(const Eigen::Vector3d& p) {
  constexpr double kPole_m = kEquator_m * (1.0 - kFlattening);
  constexpr double kSecond2 = kEccentricity2 / (1.0 - kEccentricity2);
  const double from_axis = std::hypot(p.x(), p.y());
  const double angle = std::atan2(p.z() * kEquator_m, from_axis * kPole_m);
  const double latitude = std::atan2(p.z() + kSecond2 * kPole_m * std::pow(std::sin(angle), 3),
                                     from_axis - kEccentricity2 * kEquator_m * std::pow(std::cos(angle), 3));
  const double sine = std::sin(latitude);
  // Valid at the poles too, unlike from_axis / cos.
  const double height = from_axis * std::cos(latitude) + p.z() * sine -
                        kEquator_m * std::sqrt(1.0 - kEccentricity2 * sine * sine);
  return {latitude, std::atan2(p.y(), p.x()), height};
}

Eigen::Matrix3d east_north_up(const Eigen::Vector3d& place) {
  const double sin_lat = std::sin(place.x()), cos_lat = std::cos(place.x());
  const double sin_lon = std::sin(place.y()), cos_lon = std::cos(place.y());
  Eigen::Matrix3d R;
  R << -sin_lon, cos_lon, 0.0,                          //
      -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      cos_lat * cos_lon, cos_lat * sin_lon, sin_lat;
  return R;
}

}  // namespace credence::internal
