#include "datasets/replay/mrclam_checks.h"

#include <fmt/format.h>

#include <cmath>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

// A robot that hardly moved proves nothing.
constexpr double kMinDistanceM = 5.0;
constexpr double kMinStepS = 1.0;
constexpr double kMinStepM = 0.02;

struct TruthPath {
  double length_m = 0;
  double forward_m = 0;  ///< the length weighted with the cosine between course and heading
};

/// The path in steps of at least a second, so that the jitter of the motion capture adds no length.
TruthPath measure(const MrclamLog& log, double from_s, double to_s) {
  TruthPath path;
  const MrclamPose* last = nullptr;
  for (const MrclamPose& now : log.truth) {
    if (now.time_s < from_s || now.time_s > to_s) continue;
    if (last != nullptr && now.time_s - last->time_s < kMinStepS) continue;
    if (last != nullptr) {
      const Eigen::Vector2d step = now.pose.head<2>() - last->pose.head<2>();
      const double heading = last->pose(2) + 0.5 * wrap_angle(now.pose(2) - last->pose(2));
      if (step.norm() > kMinStepM) {
        path.length_m += step.norm();
        path.forward_m += step.dot(Eigen::Vector2d(std::cos(heading), std::sin(heading)));
      }
    }
    last = &now;
  }
  return path;
}

TruthPath measure_driven(const MrclamLog& log) {
  return measure(log, log.odometry.front().time_s, log.odometry.back().time_s);
}

}  // namespace

std::string truth_contradiction(const MrclamLog& log) {
  const TruthPath path = measure_driven(log);
  if (path.length_m < kMinDistanceM || std::abs(path.forward_m) > 0.5 * path.length_m) return "";
  return fmt::format("the path of {:.1f} m goes only {:.1f} m where the robot heads: swapped columns?",
                     path.length_m, path.forward_m);
}

std::string odometry_contradiction(const MrclamLog& log) {
  if (log.odometry.front().time_s > log.truth.back().time_s ||
      log.odometry.back().time_s < log.truth.front().time_s)
    return "its times and those of the truth have nothing in common";
  double driven = 0;
  for (std::size_t i = 1; i < log.odometry.size(); ++i)
    driven += std::abs(log.odometry[i - 1].speed_mps) * (log.odometry[i].time_s - log.odometry[i - 1].time_s);
  const double length = measure_driven(log).length_m;
  if (std::max(driven, length) < kMinDistanceM || (driven < 2 * length && length < 2 * driven)) return "";
  return fmt::format("{:.1f} m driven where the truth goes {:.1f} m: swapped columns or another run?", driven,
                     length);
}

std::string measurement_contradiction(const MrclamLog& log) {
  constexpr double kRangeM = 0.5, kBearingRad = 10 * kRadiansPerDegree;
  std::size_t fit = 0, judged = 0;
  for (const MrclamMeasurement& seen : log.measurements) {
    const auto pose = truth_at(log.truth, seen.time_s);
    if (!pose) continue;
    ++judged;
    const Eigen::Vector2d to = log.landmarks[seen.landmark].position_m - pose->head<2>();
    const double bearing = std::atan2(to.y(), to.x()) - (*pose)(2);
    if (std::abs(seen.range_m - to.norm()) < kRangeM &&
        std::abs(wrap_angle(seen.bearing_rad - bearing)) < kBearingRad)
      ++fit;
  }
  if (judged == 0) return "no measurement of a landmark lies within the time of the truth";
  if (2 * fit >= judged) return "";
  return fmt::format("only {} of {} observations fit the truth and the survey: swapped columns or barcodes?",
                     fit, judged);
}

}  // namespace credence::internal
