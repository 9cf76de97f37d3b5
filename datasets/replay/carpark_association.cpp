#include "datasets/replay/carpark_association.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "datasets/replay/beacon_extraction.h"

namespace credence::internal {
namespace {

using BeaconFilter = EkfSlam<PlanarModel>;

/// EKF with every beacon an anchor: no landmark is a state.
BeaconFilter localisation(const CarparkLog& log, const Pose& start) {
  const ReplaySettings acfr = carpark_settings();
  const double steering = acfr.noise.steering_std_deg * kRadiansPerDegree;
  const double bearing = acfr.noise.bearing_std_deg * kRadiansPerDegree;
  const auto diagonal = [](double a, double b) {
    return Eigen::Matrix2d(Eigen::Vector2d(a * a, b * b).asDiagonal());
  };
  std::vector<Anchor<PlanarModel>> anchors;
  for (std::size_t i = 0; i < log.beacons_m.size(); ++i)
    anchors.push_back({static_cast<int>(i), log.beacons_m[i]});
  BeaconFilter filter(PlanarModel{Vehicle{VehicleKind::car, {}}, 0.0},
                      diagonal(acfr.noise.speed_std, steering), diagonal(acfr.noise.range_std, bearing), {},
                      anchors);
  const double heading = 5 * kRadiansPerDegree;
  filter.reset(start, Eigen::Matrix3d(Eigen::Vector3d(0.01, 0.01, heading * heading).asDiagonal()));
  return filter;
}

/// The GPS position at a time, linear between fixes, held at the ends.
Point position_at(const std::vector<CarparkGps>& gps, double time_s) {
  const auto after = std::ranges::lower_bound(gps, time_s, {}, &CarparkGps::time_s);
  if (after == gps.begin()) return gps.front().position_m;
  if (after == gps.end()) return gps.back().position_m;
  const CarparkGps& before = *(after - 1);
  const double share = (time_s - before.time_s) / (after->time_s - before.time_s);
  return before.position_m + share * (after->position_m - before.position_m);
}

struct Nearest {
  int landmark = -1;
  double distance_m = std::numeric_limits<double>::infinity();
};

Nearest nearest_beacon(const std::vector<Point>& beacons_m, const Point& place) {
  Nearest nearest;
  for (std::size_t i = 0; i < beacons_m.size(); ++i) {
    const double distance = (beacons_m[i] - place).norm();
    if (distance < nearest.distance_m) nearest = {static_cast<int>(i), distance};
  }
  return nearest;
}

ScanObservations associate_scan(const CarparkLog& log, const CarparkScan& scan, const Pose& pose,
                                double max_distance_m) {
  ScanObservations result;
  for (const BeaconObservation& seen : extract_beacons(scan)) {
    const RangeBearing z(seen.range_m, seen.bearing_rad);
    Nearest nearest = nearest_beacon(log.beacons_m, place_landmark(pose, z).position);
    if (nearest.distance_m > max_distance_m) nearest.landmark = -1;
    result.observations.push_back({nearest.landmark, z});
    result.distance_m.push_back(nearest.distance_m);
  }
  return result;
}

void correct(BeaconFilter& filter, const std::vector<LoggedObservation>& scan) {
  std::vector<Observation<PlanarModel>> observations;
  for (const LoggedObservation& observation : scan) {
    const auto same =
        std::ranges::find(observations, observation.landmark, &Observation<PlanarModel>::landmark);
    if (observation.landmark >= 0 && same == observations.end())
      observations.push_back({observation.landmark, observation.z});
  }
  filter.update(observations);
}

}  // namespace

Pose carpark_start(const CarparkLog& log, double heading_rad) {
  Pose pose;
  pose << log.gps.front().position_m, wrap_angle(heading_rad);
  return pose;
}

std::vector<int> beacons_by_first_observation(const std::vector<ScanObservations>& scans) {
  std::vector<int> order;
  for (const ScanObservations& scan : scans)
    for (const LoggedObservation& observation : scan.observations)
      if (observation.landmark >= 0 && std::ranges::find(order, observation.landmark) == order.end())
        order.push_back(observation.landmark);
  return order;
}

void check_association(const std::vector<ScanObservations>& scans) {
  std::size_t observations = 0, associated = 0;
  for (const ScanObservations& scan : scans)
    for (const LoggedObservation& observation : scan.observations) {
      ++observations;
      associated += observation.landmark >= 0 ? 1 : 0;
    }
  if (2 * associated < observations || observations == 0)
    throw DataError("beac_juan3.mat", "variable 'estbeac'",
                    fmt::format("only {} of {} observations point at a surveyed beacon: swapped columns?",
                                associated, observations));
}

std::vector<ScanObservations> associate_by_survey(const CarparkLog& log, double heading_rad,
                                                  double max_distance_m) {
  BeaconFilter filter = localisation(log, carpark_start(log, heading_rad));
  std::vector<ScanObservations> result;
  Control control = Control::Zero();
  double time_s = log.events.front().time_s;
  for (const CarparkEvent& event : log.events) {
    if (event.sensor == CarparkSensor::gps) continue;
    if (event.time_s > time_s) {
      filter.model().dt_s = event.time_s - time_s;
      filter.predict(control);
      time_s = event.time_s;
    }
    if (event.sensor == CarparkSensor::odometry) {
      control = {log.odometry[event.index].speed_mps, log.odometry[event.index].steering_rad};
    } else {
      Pose pose = filter.pose();
      pose.head<2>() = position_at(log.gps, time_s);
      result.push_back(associate_scan(log, log.scans[event.index], pose, max_distance_m));
      correct(filter, result.back().observations);
      result.back().localised = filter.pose();
    }
  }
  return result;
}

}  // namespace credence::internal
