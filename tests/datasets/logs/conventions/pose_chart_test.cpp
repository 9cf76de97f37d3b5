#include "datasets/logs/conventions/pose_chart.h"

#include <gmock/gmock.h>

#include <set>
#include <stdexcept>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

TEST(PoseChart, blocks_written_rotation_first_change_places_with_their_crosses) {
  PoseCovariance written, meant;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 6; ++j) {
      written(i, j) = static_cast<double>(10 * i + j);
      meant((i + 3) % 6, (j + 3) % 6) = written(i, j);
    }
  }
  EXPECT_EQ(pose_chart_named("gtsam").position_first(written), meant);
  for (const PoseChart& chart : pose_charts()) {
    EXPECT_EQ(chart.rotation_first, chart.name == "gtsam");
    EXPECT_EQ(chart.position_first(written), chart.rotation_first ? meant : written) << chart.name;
  }
}

TEST(PoseChart, every_name_is_of_one_chart) {
  std::set<std::string_view> names;
  for (const PoseChart& chart : pose_charts()) {
    EXPECT_TRUE(names.insert(chart.name).second) << chart.name;
    EXPECT_EQ(&pose_chart_named(chart.name), &chart);
    EXPECT_FALSE(chart.says.empty());
  }
}

// The table of docs/logs.md.
TEST(PoseChart, libraries_write_what_their_sources_say) {
  const auto axes = [](std::string_view name) { return pose_chart_named(name).axes; };
  using enum PositionError;
  using Turn = OrientationError;
  EXPECT_EQ(axes("ros"), (PoseErrorAxes{world, Turn::world, RotationUnit::vector}));
  EXPECT_EQ(axes("gtsam"), (PoseErrorAxes{twist, Turn::body, RotationUnit::vector}));
  EXPECT_EQ(axes("g2o"), (PoseErrorAxes{body, Turn::body, RotationUnit::quaternion_part}));
  EXPECT_EQ(axes("ceres"), (PoseErrorAxes{world, Turn::world, RotationUnit::half_vector}));
  EXPECT_EQ(axes("sophus"), axes("manif"));
}

TEST(PoseChart, a_meaning_of_the_orientation_is_a_chart_of_whole_angles) {
  for (const auto& [orientation, name] : {std::pair(OrientationError::world, "ros"),
                                          {OrientationError::body, "body"},
                                          {OrientationError::rpy, "rpy"},
                                          {OrientationError::planar, "planar"}}) {
    const PoseChart& chart = pose_chart_of(orientation);
    EXPECT_EQ(chart.name, name);
    EXPECT_EQ(chart.axes, (PoseErrorAxes{.orientation = orientation}));
    EXPECT_FALSE(chart.rotation_first);
  }
}

TEST(PoseChart, another_name_is_an_error_that_names_all) {
  for (const char* name : {"", "ROS", "gtsam ", "euler"}) {
    try {
      pose_chart_named(name);
      ADD_FAILURE() << name;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("--chart " + std::string(name) + ": accepted are ros ("));
      for (const PoseChart& chart : pose_charts())
        EXPECT_THAT(error.what(), HasSubstr(std::string(chart.name) + " (" + std::string(chart.says) + ")"));
    }
  }
}

}  // namespace
}  // namespace credence::internal
