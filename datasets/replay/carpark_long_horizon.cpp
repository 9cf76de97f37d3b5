#include "datasets/replay/carpark_long_horizon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/filters/ekf_slam.h"
#include "core/manifold/angle.h"
#include "core/stop_point.h"
#include "datasets/replay/carpark_replay.h"

namespace credence::internal {
namespace {

/// A model whose motion is prescribed: the reference path. The noise enters as a factor of its covariance.
struct ReferenceModel {
  static constexpr int kPose = 3, kControl = 3, kLandmark = 2, kMeasurement = 2;

  struct Step {
    Pose pose = Pose::Zero();
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d G = Eigen::Matrix3d::Zero();  ///< G Gᵀ is the noise of the step
  };
  Step next;

  const Step& move(const Pose&, const Eigen::Vector3d&) const { return next; }
  static PredictedRangeBearing predict(const Pose& pose, const Point& landmark) {
    return predict_range_bearing(pose, landmark);
  }
  static PlacedLandmark place(const Pose& pose, const RangeBearing& z) { return place_landmark(pose, z); }
  static RangeBearing innovation(const RangeBearing& z, const RangeBearing& predicted) {
    return range_bearing_innovation(z, predicted);
  }
  static void wrap_pose(Pose& pose) { pose[2] = wrap_angle(pose[2]); }
};

using ReferenceFilter = EkfSlam<ReferenceModel>;
using Drive = std::vector<std::pair<Control, double>>;  ///< controls and their durations in seconds

/// One scan that saw a beacon: where, what, and how the vehicle came there from the station before.
struct Station {
  Pose pose = Pose::Zero();
  std::vector<int> beacons;
  Drive drive;
};

std::vector<Station> stations_of(const CarparkLog& log, const std::vector<ScanObservations>& scans,
                                 Index stride) {
  std::vector<Station> stations;
  Station next;
  Control control = Control::Zero();
  double time_s = log.events.front().time_s;
  Index seen = 0;
  for (const CarparkEvent& event : log.events) {
    if (event.sensor == CarparkSensor::gps) continue;
    if (event.time_s > time_s) next.drive.emplace_back(control, event.time_s - time_s);
    time_s = event.time_s;
    if (event.sensor == CarparkSensor::odometry) {
      control = {log.odometry[event.index].speed_mps, log.odometry[event.index].steering_rad};
      continue;
    }
    for (const LoggedObservation& observation : scans[event.index].observations)
      if (observation.landmark >= 0) next.beacons.push_back(observation.landmark);
    std::ranges::sort(next.beacons);
    next.beacons.erase(std::unique(next.beacons.begin(), next.beacons.end()), next.beacons.end());
    if (!next.beacons.empty() && seen++ % stride == 0) {
      next.pose = scans[event.index].localised;
      stations.push_back(std::move(next));
      next = {};
    }
    next.beacons.clear();
  }
  return stations;
}

/// A factor of the noise that a drive from a pose adds up to; backwards: the same way in reverse gear.
Eigen::Matrix3d noise_factor(const Vehicle& vehicle, Pose pose, Drive drive, bool backwards,
                             const Eigen::Matrix2d& Q) {
  if (backwards) {
    std::reverse(drive.begin(), drive.end());
    for (auto& [control, duration] : drive) control(0) = -control(0);
  }
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  for (const auto& [control, duration_s] : drive) {
    const Motion motion = vehicle.move(pose, control, duration_s);
    noise = motion.F * noise * motion.F.transpose() + motion.G * Q * motion.G.transpose();
    pose = motion.pose;
  }
  // Robust against rank 2, which a single sample has.
  const Eigen::LDLT<Eigen::Matrix3d> factor(noise);
  const Eigen::Vector3d roots = factor.vectorD().cwiseMax(0.0).cwiseSqrt();
  return factor.transpositionsP().transpose() * Eigen::Matrix3d(factor.matrixL()) * roots.asDiagonal();
}

/// The step between two poses, whatever drove it: for every planar vehicle F depends on the displacement
/// alone.
ReferenceModel::Step step_between(const Pose& from, const Pose& to, const Eigen::Matrix3d& G) {
  ReferenceModel::Step step{to, Eigen::Matrix3d::Identity(), G};
  step.F(0, 2) = -(to(1) - from(1));
  step.F(1, 2) = to(0) - from(0);
  return step;
}

ReferenceFilter make_filter(const CarparkLog& log, const ReplaySettings& settings,
                            const std::vector<int>& order) {
  std::vector<Anchor<ReferenceModel>> anchors;
  const auto count = settings.world.full ? static_cast<std::size_t>(settings.world.anchors) : 0;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i)
    anchors.push_back({order[i], log.beacons_m[static_cast<std::size_t>(order[i])]});
  const double range = settings.noise.range_std;
  const double bearing = settings.noise.bearing_std_deg * kRadiansPerDegree;
  const Eigen::Matrix2d R = Eigen::Vector2d(range * range, bearing * bearing).asDiagonal();
  return ReferenceFilter({}, Eigen::Matrix3d::Identity(), R,
                         {settings.filter.inflation, settings.filter.solution, {}}, anchors);
}

void reset(ReferenceFilter& filter, const Pose& start, const ReplayInitial& initial) {
  const double position = initial.position_std, heading = initial.heading_std_deg * kRadiansPerDegree;
  filter.reset(
      start, Eigen::Matrix3d(
                 Eigen::Vector3d(position * position, position * position, heading * heading).asDiagonal()));
}

/// Noise-free observations of the beacons of a station; false when the update failed.
bool observe(ReferenceFilter& filter, const CarparkLog& log, const Station& station,
             LongHorizonResult& result) {
  std::vector<Observation<ReferenceModel>> observations;
  for (const int beacon : station.beacons)
    observations.push_back(
        {beacon, measure_range_bearing(station.pose, log.beacons_m[static_cast<std::size_t>(beacon)])});
  const UpdateResult update = filter.update(observations);
  ++result.steps;
  if (!update.converged) ++result.not_converged;
  return update.ok;
}

}  // namespace

double LongHorizonResult::fitted_exponent() const {
  double n = 0, x_sum = 0, y_sum = 0, xx = 0, xy = 0;
  for (std::size_t i = loops.size() / 2; i < loops.size(); ++i) {
    const double x = std::log(static_cast<double>(i + 1)), y = std::log(loops[i].landmarks);
    n += 1;
    x_sum += x;
    y_sum += y;
    xx += x * x;
    xy += x * y;
  }
  return n < 2 ? 0 : (n * xy - x_sum * y_sum) / (n * xx - x_sum * x_sum);
}

double LongHorizonResult::increment_ratio() const {
  const std::size_t first = std::max<std::size_t>(1, loops.size() / 2), last = loops.size() - 1;
  if (loops.empty() || last <= first) return 1;
  const double early = loops[first].landmarks - loops[first - 1].landmarks;
  const double late = loops[last].landmarks - loops[last - 1].landmarks;
  if (early <= 0 || late <= 0) return 1;
  return std::pow(late / early, 1.0 / static_cast<double>(last - first));
}

double LongHorizonResult::growth_per_loop() const {
  return loops.size() < 2 ? 1 : loops.back().landmarks / loops[loops.size() - 2].landmarks;
}

LongHorizonResult carpark_long_horizon(const CarparkLog& log, const ReplaySettings& settings,
                                       const LongHorizonPlan& plan) {
  check_replay_settings(settings);
  if (settings.vehicle != VehicleKind::car)
    throw std::invalid_argument("the car park needs the settings of a car");
  if (plan.loops < 1) throw std::invalid_argument(fmt::format("loops {} must be >= 1", plan.loops));
  if (plan.scan_stride < 1)
    throw std::invalid_argument(fmt::format("scan_stride {} must be >= 1", plan.scan_stride));

  const std::vector<ScanObservations> scans = carpark_scans(log);
  const std::vector<Station> stations = stations_of(log, scans, plan.scan_stride);
  const double steering = settings.noise.steering_std_deg * kRadiansPerDegree;
  const double speed = settings.noise.speed_std;
  const Eigen::Matrix2d Q = Eigen::Vector2d(speed * speed, steering * steering).asDiagonal();
  const Vehicle car{VehicleKind::car, {}};

  ReferenceFilter filter = make_filter(log, settings, beacons_by_first_observation(scans));
  reset(filter, stations.front().pose, settings.initial);
  LongHorizonResult result;
  const auto visit = [&](std::size_t from, std::size_t to) {
    stop_point();
    const bool backwards = to < from;
    const Station& driven = stations[std::max(from, to)];
    filter.model().next = step_between(stations[from].pose, stations[to].pose,
                                       noise_factor(car, stations[from].pose, driven.drive, backwards, Q));
    filter.predict(Eigen::Vector3d::Zero());
    result.ok = observe(filter, log, stations[to], result);
    return result.ok;
  };
  if (!(result.ok = observe(filter, log, stations.front(), result))) return result;
  for (Index loop = 0; loop < plan.loops; ++loop) {
    for (std::size_t k = 1; k < stations.size(); ++k)
      if (!visit(k - 1, k)) return result;
    for (std::size_t k = stations.size() - 1; k > 0; --k)
      if (!visit(k, k - 1)) return result;
    const Matrix& P = filter.covariance();
    result.loops.push_back({P(0, 0) + P(1, 1), P.diagonal().tail(P.rows() - 3).sum()});
  }
  return result;
}

}  // namespace credence::internal
