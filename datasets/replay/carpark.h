#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// A position of the car park's GPS receiver, 2 cm kinematic, in the local frame x = East, y = North.
struct CarparkGps {
  double time_s = 0;
  Eigen::Vector2d position_m;
};

/// One sample of the encoder and the steering sensor.
struct CarparkOdometry {
  double time_s = 0;
  double speed_mps = 0;     ///< of the rear left wheel
  double steering_rad = 0;  ///< left positive
};

/// One sweep of the laser: beam k (from 0) looks at k·0.5° − 90° to the vehicle's axis, left positive.
struct CarparkScan {
  double time_s = 0;
  Vector range_m;    ///< 81.8 and more: no return
  Vector intensity;  ///< above 0: a reflective beacon
};

enum class CarparkSensor { gps = 1, odometry = 2, laser = 3 };

/// One entry of the merged record: which sensor spoke when, and where in its list the sample lies.
struct CarparkEvent {
  double time_s = 0;
  CarparkSensor sensor = CarparkSensor::gps;
  std::size_t index = 0;  ///< from 0, into the list of that sensor
};

/// The car park run of 16 May 2001 ([Nebot 2002], docs/datasets.md).
struct CarparkLog {
  std::vector<CarparkEvent> events;  ///< in order of time
  std::vector<CarparkGps> gps;
  std::vector<CarparkOdometry> odometry;
  std::vector<CarparkScan> scans;
  std::vector<Eigen::Vector2d> beacons_m;  ///< surveyed, East and North
};

/// Reads `data_set.mat` and `beac_juan3.mat` from a folder.
///
/// Throws DataError that names file and variable for whatever is missing, of the wrong shape, out of order in
/// time, or impossible (an index out of range, a steering angle beyond a right angle, a negative range).
CarparkLog read_carpark(const std::filesystem::path& folder);

}  // namespace credence::internal
