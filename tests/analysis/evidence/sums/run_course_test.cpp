#include "analysis/evidence/sums/run_course.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

TEST(RunCourse, CountsTheRowsThatNoConsistentFilterHas) {
  // P(χ²₃ > x) = erfc √(x/2) + √(2x/π) e^(−x/2) is 1e-9 at 44.841, 14.947 for each dof.
  const std::vector<double> nees = {1.0, 14.9, 15.0, 2.0, 30.0};
  const RunCourse course = course_of(nees, 3.0);
  EXPECT_EQ(course.rows, 5);
  EXPECT_EQ(course.beyond, 2);
  EXPECT_EQ(course.first, 3);
  EXPECT_DOUBLE_EQ(course.mean, 62.9 / 5.0);
}

}  // namespace
}  // namespace credence::internal
