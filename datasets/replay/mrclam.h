#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// One sample of a robot's wheel odometry; it holds until the next.
struct MrclamOdometry {
  double time_s = 0;
  double speed_mps = 0;
  double turn_rate_rps = 0;
};

/// One observation of a landmark.
struct MrclamMeasurement {
  double time_s = 0;
  std::size_t landmark = 0;  ///< from 0, into MrclamLog::landmarks
  double range_m = 0;
  double bearing_rad = 0;  ///< 0 ahead, left positive
};

/// One pose of the motion capture.
struct MrclamPose {
  double time_s = 0;
  Eigen::Vector3d pose;  ///< x m, y m, heading rad
};

struct MrclamLandmark {
  int subject = 0;
  Eigen::Vector2d position_m;
};

/// The log of one robot ([Leung 2011], docs/datasets.md).
///
/// All times are Unix seconds and in order.
struct MrclamLog {
  int robot = 0;
  std::vector<MrclamLandmark> landmarks;
  std::vector<MrclamOdometry> odometry;
  std::vector<MrclamMeasurement> measurements;  ///< of landmarks
  std::vector<MrclamPose> truth;

  Index rows_of_robots = 0;            ///< measurements of another robot, not used
  Index rows_of_unknown_barcodes = 0;  ///< measurements whose barcode nobody wears, not used
};

/// Reads `Barcodes.dat`, `Landmark_Groundtruth.dat` and the three files of robot `robot` from a folder.
///
/// Throws DataError that names file and line for whatever is missing, malformed, out of order in time or
/// impossible (a barcode worn twice, a negative range, an angle beyond π), and std::invalid_argument for a
/// robot number outside 1 … 5. Swapped columns are found where they contradict the other files: the truth
/// must move where it heads, and the odometry as far as the truth.
MrclamLog read_mrclam(const std::filesystem::path& folder, int robot);

/// The numbers of the robots whose odometry lies in the folder, ascending.
std::vector<int> mrclam_robots(const std::filesystem::path& folder);

/// The true pose at a time, linear between two samples (heading along the shorter arc).
///
/// Empty outside the record and within a gap longer than 0.5 s: the motion capture lost the robot
/// there. Precondition: `truth` in order of time. O(log n).
std::optional<Eigen::Vector3d> truth_at(const std::vector<MrclamPose>& truth, double time_s);

}  // namespace credence::internal
