#include "datasets/replay/carpark_replay.h"

#include <stdexcept>

#include "core/manifold/angle.h"
#include "datasets/replay/carpark_association.h"
#include "datasets/replay/replay_filter.h"

namespace credence::internal {

namespace {

void require_car(const ReplaySettings& settings) {
  check_replay_settings(settings);
  if (settings.vehicle != VehicleKind::car)
    throw std::invalid_argument("the car park needs the settings of a car");
}

}  // namespace

std::vector<ScanObservations> carpark_scans(const CarparkLog& log) {
  std::vector<ScanObservations> scans =
      associate_by_survey(log, carpark_settings().initial.heading_deg * kRadiansPerDegree);
  check_association(scans);
  return scans;
}

ReplayResult replay_carpark(const CarparkLog& log, const ReplaySettings& settings) {
  require_car(settings);
  return replay_carpark(log, carpark_scans(log), settings);
}

ReplayResult replay_carpark(const CarparkLog& log, const std::vector<ScanObservations>& scans,
                            const ReplaySettings& settings) {
  require_car(settings);
  const double heading = settings.initial.heading_deg * kRadiansPerDegree;
  ReplayStart start;
  start.time_s = log.events.front().time_s;
  start.pose = carpark_start(log, heading);
  start.survey_m = log.beacons_m;
  start.first_seen = beacons_by_first_observation(scans);
  ReplayFilter filter(settings, start);

  // A delay moves the odometry against the other sensors: merge again.
  std::size_t odometry = 0;
  const auto drive_to = [&](double time_s) {
    for (; odometry < log.odometry.size(); ++odometry) {
      const CarparkOdometry& sample = log.odometry[odometry];
      if (sample.time_s + settings.sensor.odometry_delay_s > time_s) break;
      filter.advance_to(sample.time_s + settings.sensor.odometry_delay_s);
      filter.set_control({settings.sensor.speed_scale * sample.speed_mps, sample.steering_rad});
    }
  };
  for (const CarparkEvent& event : log.events) {
    drive_to(event.time_s);
    if (event.sensor == CarparkSensor::gps)
      filter.compare_position(event.time_s, log.gps[event.index].position_m);
    if (event.sensor == CarparkSensor::laser) {
      filter.advance_to(event.time_s);
      filter.observe(event.time_s, scans[event.index].observations);
    }
  }
  ReplayResult result = filter.finish();
  result.dataset = "carpark";
  return result;
}

}  // namespace credence::internal
