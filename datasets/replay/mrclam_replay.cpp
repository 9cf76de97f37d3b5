#include "datasets/replay/mrclam_replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "datasets/replay/replay_filter.h"

namespace credence::internal {
namespace {

constexpr double kMaxStepS = 0.02;

/// The first odometry sample at which the true pose is known.
std::size_t first_sample(const MrclamLog& log, double delay_s) {
  for (std::size_t i = 0; i < log.odometry.size(); ++i)
    if (truth_at(log.truth, log.odometry[i].time_s + delay_s)) return i;
  throw DataError(fmt::format("Robot{}_Groundtruth.dat", log.robot), "",
                  "has no pose at the time of any odometry sample");
}

/// A depth says nothing of a landmark beside or behind the camera.
void check_bearings(const MrclamLog& log, const ReplaySettings& settings) {
  constexpr double kMaxBearingRad = 85 * kRadiansPerDegree;
  if (settings.sensor.range != RangeKind::depth) return;
  for (const MrclamMeasurement& seen : log.measurements)
    if (std::abs(seen.bearing_rad) > kMaxBearingRad)
      throw std::invalid_argument(
          fmt::format("sensor.range = depth: a landmark was seen at a bearing of {:.1f} degrees",
                      seen.bearing_rad / kRadiansPerDegree));
}

std::vector<int> first_seen(const MrclamLog& log, double from_s) {
  std::vector<int> order;
  for (const MrclamMeasurement& seen : log.measurements) {
    const int landmark = static_cast<int>(seen.landmark);
    if (seen.time_s >= from_s && std::ranges::find(order, landmark) == order.end()) order.push_back(landmark);
  }
  return order;
}

/// Feeds the odometry of a log up to any time, holding each sample and capping the hold.
class Driver {
 public:
  Driver(const MrclamLog& log, ReplayFilter& filter, std::size_t first, const ReplaySensor& sensor)
      : log_(log), filter_(filter), next_(first), sensor_(sensor) {}

  void drive_to(double time_s) {
    while (next_ < log_.odometry.size() && time_of(next_) <= time_s) {
      hold_to(time_of(next_));
      const MrclamOdometry& sample = log_.odometry[next_];
      filter_.set_control(
          {sensor_.speed_scale * sample.speed_mps,
           sensor_.turn_scale * sample.turn_rate_rps + sensor_.turn_drift_deg_s * kRadiansPerDegree});
      since_s_ = time_of(next_);
      ++next_;
    }
    hold_to(time_s);
  }

 private:
  double time_of(std::size_t i) const { return log_.odometry[i].time_s + sensor_.odometry_delay_s; }

  void hold_to(double time_s) {
    if (time_s - since_s_ > kMrclamMaxHoldS) {
      step_to(since_s_ + kMrclamMaxHoldS);
      filter_.set_control(Control::Zero());
    }
    step_to(time_s);
  }

  /// Noise is per sample: without the short steps a gap in the log would count as one long constant error.
  void step_to(double time_s) {
    while (time_s - filter_.time_s() > kMaxStepS) filter_.advance_to(filter_.time_s() + kMaxStepS);
    filter_.advance_to(time_s);
  }

  const MrclamLog& log_;
  ReplayFilter& filter_;
  std::size_t next_;
  ReplaySensor sensor_;
  double since_s_ = 0;
};

}  // namespace

ReplayResult replay_mrclam(const MrclamLog& log, const ReplaySettings& settings) {
  check_replay_settings(settings);
  if (settings.vehicle != VehicleKind::unicycle)
    throw std::invalid_argument("MRCLAM needs the settings of a unicycle");
  check_bearings(log, settings);
  const double delay_s = settings.sensor.odometry_delay_s;
  const std::size_t first = first_sample(log, delay_s);
  ReplayStart start;
  start.time_s = log.odometry[first].time_s + delay_s;
  start.pose = *truth_at(log.truth, start.time_s);
  for (const MrclamLandmark& landmark : log.landmarks) start.survey_m.push_back(landmark.position_m);
  start.first_seen = first_seen(log, start.time_s);
  start.truth = [&log](double time_s) { return truth_at(log.truth, time_s); };
  ReplayFilter filter(settings, start);
  Driver driver(log, filter, first, settings.sensor);

  Index before_start = 0, without_truth = 0;
  for (std::size_t i = 0; i < log.measurements.size();) {
    const double time_s = log.measurements[i].time_s;
    std::vector<LoggedObservation> observations;
    for (; i < log.measurements.size() && log.measurements[i].time_s == time_s; ++i) {
      const MrclamMeasurement& seen = log.measurements[i];
      observations.push_back({static_cast<int>(seen.landmark), {seen.range_m, seen.bearing_rad}});
    }
    if (time_s < start.time_s) {
      before_start += static_cast<Index>(observations.size());
      continue;
    }
    driver.drive_to(time_s);
    filter.observe(time_s, observations);
    if (const auto truth = truth_at(log.truth, time_s)) {
      filter.compare_pose(time_s, *truth);
    } else {
      ++without_truth;
    }
  }
  driver.drive_to(log.odometry.back().time_s + delay_s);
  ReplayResult result = filter.finish();
  result.dataset = "mrclam";
  result.run = fmt::format("robot {}", log.robot);
  result.rows_of_robots = log.rows_of_robots;
  result.rows_of_unknown_barcodes = log.rows_of_unknown_barcodes;
  result.rows_before_start = before_start;
  result.times_without_truth = without_truth;
  return result;
}

}  // namespace credence::internal
