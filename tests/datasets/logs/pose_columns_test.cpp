#include "datasets/logs/pose_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

std::string numbered(const std::string& format, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "," + fmt::format(fmt::runtime(format), i);
  return text;
}

TEST(PoseColumns, AHeaderNamesThemInAnyOrder) {
  const auto columns =
      csv_pose_columns("frame,qw,qx,qy,qz,x,y,z,timestamp [ns]" + numbered("cov_{}", 36) + ",vx", true);
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->time, 8U);
  EXPECT_EQ(columns->seconds_per_unit, 1e-9);
  EXPECT_THAT(columns->position, ElementsAre(5, 6, 7));
  EXPECT_THAT(columns->orientation, ElementsAre(2, 3, 4, 1));
  ASSERT_EQ(columns->joint_covariance.size(), 36U);
  EXPECT_EQ(columns->joint_covariance.front(), 9U);
  EXPECT_EQ(columns->fewest, 46U);
}

TEST(PoseColumns, ACovarianceThatWasSortedAsTextIsTakenByItsNumbers) {
  std::vector<std::string> names;
  for (int i = 0; i < 36; ++i) names.push_back(fmt::format("covariance_{}", i));
  std::ranges::sort(names);  // covariance_0, covariance_1, covariance_10, …
  const auto columns = csv_pose_columns(fmt::format("t,x,y,z,qx,qy,qz,qw,{}", fmt::join(names, ",")), true);
  ASSERT_TRUE(columns);
  ASSERT_EQ(columns->joint_covariance.size(), 36U);
  for (std::size_t i = 0; i < 36; ++i)
    EXPECT_EQ(names[columns->joint_covariance[i] - 8], fmt::format("covariance_{}", i));
}

TEST(PoseColumns, FieldsOfRosAreNames) {
  std::string header = "header.stamp.sec,header.stamp.nanosec,header.frame_id";
  for (const char* axis : {"x", "y", "z"}) header += fmt::format(",pose.pose.position.{}", axis);
  for (const char* axis : {"x", "y", "z", "w"}) header += fmt::format(",pose.pose.orientation.{}", axis);
  header += numbered("pose.covariance[{}]", 36);
  for (const char* axis : {"x", "y", "z"}) header += fmt::format(",twist.twist.linear.{}", axis);
  header += numbered("twist.covariance[{}]", 36);
  const auto columns = csv_pose_columns(header, true);
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->time, 0U);
  EXPECT_EQ(columns->nanoseconds, 1U);
  EXPECT_THAT(columns->position, ElementsAre(3, 4, 5));
  EXPECT_THAT(columns->orientation, ElementsAre(6, 7, 8, 9));
  EXPECT_EQ(columns->joint_covariance.back(), 45U);
}

TEST(PoseColumns, AnUpperTriangleWillDo) {
  const std::string pose = "t,tx,ty,tz,q_x,q_y,q_z,q_w";
  const auto counted = csv_pose_columns(pose + numbered("covariance{}", 21), true);
  ASSERT_TRUE(counted);
  EXPECT_EQ(counted->joint_covariance.size(), 21U);
  std::string header = pose;
  for (int i = 1; i <= 6; ++i) {
    for (int j = 1; j <= 6; ++j) header += fmt::format(",P.{}.{}", i, j);
  }
  const auto named = csv_pose_columns(header, true);
  ASSERT_TRUE(named);
  ASSERT_EQ(named->joint_covariance.size(), 21U);
  EXPECT_EQ(named->joint_covariance[6], 8U + 7U);  // P.2.2
}

TEST(PoseColumns, RowsWithoutAHeaderAreKnownByTheirLength) {
  const std::string row = "1.5,1,2,3,0,0,0,1";
  EXPECT_EQ(csv_pose_columns(row + numbered("{}", 36), true)->joint_covariance.size(), 36U);
  EXPECT_EQ(csv_pose_columns(row + numbered("{}", 21), true)->joint_covariance.size(), 21U);
  EXPECT_FALSE(csv_pose_columns(row + numbered("{}", 20), true));
  EXPECT_FALSE(csv_pose_columns(row, true));
  EXPECT_TRUE(csv_pose_columns(row, false));
  EXPECT_FALSE(csv_pose_columns("1.5 1 2 3 0 0 0 1", false));
}

TEST(PoseColumns, RowsThatRos2PrintsAreKnownByTheirFrames) {
  const std::string pose = ",1,2,3,0,0,0,1" + numbered("{}", 36);
  const auto stamped = csv_pose_columns("10,500,map" + pose, true);
  ASSERT_TRUE(stamped);
  EXPECT_EQ(stamped->nanoseconds, 1U);
  EXPECT_THAT(stamped->position, ElementsAre(3, 4, 5));
  EXPECT_EQ(stamped->joint_covariance.front(), 10U);
  const auto odometry = csv_pose_columns("10,500,odom,base" + pose + numbered("{}", 42), true);
  ASSERT_TRUE(odometry);
  EXPECT_THAT(odometry->orientation, ElementsAre(7, 8, 9, 10));
  EXPECT_EQ(odometry->joint_covariance.front(), 11U);
}

TEST(PoseColumns, UnitsOfPositionsAreKept) {
  EXPECT_THAT(csv_pose_columns("t,x [mm],y ( mm ),z", false)->position_units, ElementsAre("mm", "mm", ""));
}

TEST(PoseColumns, OtherHeadersAreNoPoses) {
  EXPECT_FALSE(csv_pose_columns("step,estimate.x,truth.x,P.1.1", true));
  EXPECT_FALSE(csv_pose_columns("timestamp,x,y,z,qx,qy,qz,qw", true));  // no covariance
  EXPECT_TRUE(csv_pose_columns("timestamp,x,y,z,qx,qy,qz,qw", false));
  EXPECT_FALSE(csv_pose_columns("x,y,z,qx,qy,qz,qw" + numbered("cov_{}", 36), true));  // no time
  EXPECT_FALSE(
      csv_pose_columns("#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x []", false));
}

}  // namespace
}  // namespace credence::internal
