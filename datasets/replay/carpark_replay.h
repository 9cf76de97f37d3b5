#pragma once

#include <vector>

#include "datasets/replay/carpark.h"
#include "datasets/replay/carpark_association.h"
#include "datasets/replay/replay_result.h"

namespace credence::internal {

/// EKF-SLAM with the car model on the car park run (the paper's Figures 5 to 8).
///
/// Events in order of time; odometry holds between its samples; one prediction at each odometry sample and
/// at each scan; starts at the first GPS fix. The result's vehicle_nees is that of the GPS position, 2 dof,
/// with the receiver's 2 cm added. Throws std::invalid_argument for impossible settings, and DataError when
/// fewer than half of the observations point at a surveyed beacon (swapped columns, or another survey).
ReplayResult replay_carpark(const CarparkLog& log, const ReplaySettings& settings);

/// The scans of a log with their beacons, which no setting changes. Throws DataError as replay_carpark.
std::vector<ScanObservations> carpark_scans(const CarparkLog& log);

/// The same with carpark_scans(log), for who replays a log often.
ReplayResult replay_carpark(const CarparkLog& log, const std::vector<ScanObservations>& scans,
                            const ReplaySettings& settings);

}  // namespace credence::internal
