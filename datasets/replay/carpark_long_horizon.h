#pragma once

#include <vector>

#include "datasets/replay/carpark.h"
#include "datasets/replay/replay_settings.h"

namespace credence::internal {

/// How far the car park is driven: forth along the recorded path, back along it, and so on.
struct LongHorizonPlan {
  Index loops = 10;       ///< one loop is forth and back, about four laps
  Index scan_stride = 1;  ///< use every so manieth scan that saw a beacon
};

/// Traces of P in m², after a loop, when the vehicle is back at the start.
struct LongHorizonLoop {
  double vehicle = 0;    ///< of the position
  double landmarks = 0;  ///< of all landmarks in the state
};

struct LongHorizonResult {
  std::vector<LongHorizonLoop> loops;
  Index steps = 0;  ///< updates in all
  Index not_converged =
      0;           ///< of them, with a minimal trace that missed its tolerance: beware of slow growth
  bool ok = true;  ///< false: an innovation covariance was not positive definite; loops is shorter

  /// The least-squares slope of the log of the landmarks' trace over log loop, in the second half of the
  /// loops: 0 flat, 1 linear growth, and increasing with the number of loops for exponential growth.
  double fitted_exponent() const;

  /// By what the growth of a loop exceeds that of the loop before: the geometric mean over the second half. 1
  /// for linear growth with any offset, above 1 for exponential growth; 1 where nothing grows.
  double increment_ratio() const;

  /// The landmarks' trace after the last loop over that after the last but one. 1 with fewer than two loops.
  double growth_per_loop() const;
};

/// The covariance recursion of EKF-SLAM with Jacobians along the reference path, for as long as one likes:
/// what two laps hide (theory, section 5).
///
/// The reference is a localisation on the survey; every scan shows the beacons that it showed on the day, at
/// their surveyed places and without noise, so that the state stays at the reference and P alone evolves. F
/// of an interval is exact for the reference's displacement, its Q the sum over the odometry samples.
/// Settings as for the replay, of which noise, initial deviations, world and inflation count. Throws
/// std::invalid_argument for impossible settings or plans and DataError as the replay does.
LongHorizonResult carpark_long_horizon(const CarparkLog& log, const ReplaySettings& settings,
                                       const LongHorizonPlan& plan);

}  // namespace credence::internal
