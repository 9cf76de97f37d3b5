#pragma once

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// One epoch of a positioning solution.
struct GnssFix {
  double time_s = 0.0;  ///< since the first day of GPS week 0, of the time system of the file
  std::int64_t line = 0;
  Eigen::Vector3d earth_fixed = Eigen::Vector3d::Zero();  ///< m; of a baseline: east, north, up
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();   ///< of east, north, up; m²
  int quality = 0;                                        ///< 1 fix, 2 float, 3 SBAS, 4 DGPS, 5 single, 6 PPP
};

/// A solution file of RTKLIB (manual 2.4.2, B.1): latitude, longitude and height in degrees, earth-fixed x y
/// z, or a baseline east north up; times as calendar dates or as week and seconds.
struct GnssSolution {
  std::filesystem::path file;
  bool baseline = false;
  std::string time_system{};  ///< "GPST", "UTC" or "JST", as the line that names the columns says; else empty
  std::vector<GnssFix> fixes{};
};

/// Reads a solution. The columns sdne, sdeu, sdun hold sign(c) √|c| of the covariances c. Throws DataError
/// with the line: no header that names the columns, a field that is no number, times that do not increase;
/// the rows before it are then in `part`.
GnssSolution read_rtklib(const std::filesystem::path& file, GnssSolution* part = nullptr);

/// --input rtklib: a solution against --truth, which is another one: a better solution, whose covariance is
/// added, or a survey point (a file of one epoch, which then holds for all times). The states are east, north
/// and up of each quality that is there, so that each has a verdict of its own.
LogFormat rtklib_format();

}  // namespace credence::internal
