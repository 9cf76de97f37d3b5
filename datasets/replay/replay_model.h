#pragma once

#include <optional>
#include <vector>

#include "core/models/slam_model.h"

namespace credence::internal {

/// Where the Jacobians of one step are taken when not at the estimates.
struct ReplayTruthPoint {
  Pose from, to;                  ///< true poses before and after the motion
  std::vector<Point> survey_m;    ///< true landmarks
  std::vector<int> observations;  ///< landmarks of the next update's known observations, in their order
};

/// The planar model of a replay; with a truth point its F, G, H are those at the truth, while states and
/// innovations stay those of the estimate.
///
/// The "ideal" EKF of [Huang 2010]: linearised there it knows
/// that the frame of the map is unobservable, and gains no heading from landmarks that it placed itself.
struct ReplayModel : PlanarModel {
  std::optional<ReplayTruthPoint> truth;

  Motion move(const Pose& pose, const Control& u) const {
    Motion motion = vehicle.move(pose, u, dt_s);
    if (!truth) return motion;
    // For every planar vehicle F depends on the displacement alone.
    motion.G = vehicle.move(truth->from, u, dt_s).G;
    motion.F = Eigen::Matrix3d::Identity();
    motion.F(0, 2) = -(truth->to(1) - truth->from(1));
    motion.F(1, 2) = truth->to(0) - truth->from(0);
    return motion;
  }

  PredictedRangeBearing predict(const Pose& pose, const Point& landmark) const {
    PredictedRangeBearing result = predict_range_bearing(pose, landmark);
    if (!truth) return result;
    const int id = truth->observations.at(next_observation++ % truth->observations.size());
    const auto at = predict_range_bearing(truth->to, truth->survey_m[static_cast<std::size_t>(id)]);
    result.H_r = at.H_r;
    result.H_l = at.H_l;
    return result;
  }

  PlacedLandmark place(const Pose& pose, const RangeBearing& z) const {
    PlacedLandmark result = place_landmark(pose, z);
    if (!truth) return result;
    const PlacedLandmark at = place_landmark(truth->to, z);
    result.J_r = at.J_r;
    result.J_z = at.J_z;
    return result;
  }

  mutable std::size_t next_observation =
      0;  ///< EkfSlam asks for the observations of an update in their order
};

}  // namespace credence::internal
