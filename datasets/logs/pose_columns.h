#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace credence::internal {

/// Which column of a file of poses holds what, from 0.
struct PoseColumns {
  bool commas = false;
  std::size_t fewest = 8, most = 8;  ///< columns of a row
  std::size_t time = 0;
  std::optional<std::size_t> nanoseconds{};  ///< beside whole seconds
  double seconds_per_unit = 1.0;
  std::array<std::size_t, 3> position{1, 2, 3};
  std::array<std::string, 3> position_units{};         ///< "mm" of "x [mm]"; "" where the header tells none
  std::array<std::size_t, 4> orientation{4, 5, 6, 7};  ///< x y z w
  bool has_orientation = true;  ///< false: positions alone, as of a prism or an antenna
  std::vector<std::size_t> position_covariance{}, orientation_covariance{};  ///< upper triangles
  std::vector<std::size_t> joint_covariance{};  ///< upper triangle of 6×6, or all by rows
  std::optional<std::size_t> error_type{}, error_representation{};  ///< words of cnspy
};

/// So many columns side by side.
std::vector<std::size_t> columns_from(std::size_t first, std::size_t count);

/// The columns of poses that the first line of a CSV tells: a header with names such as timestamp, x, y, z,
/// qx, qy, qz, qw, covariance_0 …, or those of the fields of ROS; or, without a header, a row of t x y z qx
/// qy qz qw and a covariance, or one that `ros2 topic echo --csv` prints of a pose with covariance or an
/// odometry. Nothing for another line; with_covariance: also for one without a covariance. Otherwise
/// positions alone will do, a header without any part of a quaternion or rows t x y z.
std::optional<PoseColumns> csv_pose_columns(std::string_view line, bool with_covariance);

/// Whether the line is a header, and no row.
bool is_pose_header(std::string_view line);

}  // namespace credence::internal
