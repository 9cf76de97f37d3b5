#include "montecarlo/worlds/planar/covariance_statistics.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/nan.h"
#include "tests/core/record/judged_error.h"

namespace credence::internal {
namespace {

TEST(PoseNees, is_that_of_the_first_three_states) {
  const JudgedError j(11);
  NeesSolver solver;
  const NeesValue pose = pose_nees(j.e, j.P, solver);
  EXPECT_EQ(pose.dof, 3);
  EXPECT_NEAR(pose.value, square_by_lu(j.e.head(3), j.P.topLeftCorner(3, 3)), 1e-9 * pose.value);
  Matrix sure = j.P;
  sure.row(2).setZero();
  sure.col(2).setZero();
  const NeesValue place = pose_nees(j.e, sure, solver);
  EXPECT_EQ(place.dof, 2);
  EXPECT_NEAR(place.value, square_by_lu(j.e.head(2), j.P.topLeftCorner(2, 2)), 1e-9 * place.value);
  sure(0, 0) = -1.0;
  EXPECT_EQ(pose_nees(j.e, sure, solver).dof, -1);
  for (const double value : {kNaN, std::numeric_limits<double>::infinity()}) {
    Matrix infinite = j.P;
    infinite(2, 1) = infinite(1, 2) = value;
    EXPECT_EQ(pose_nees(j.e, infinite, solver).dof, -1) << value;
  }
  Vector e = j.e;
  e[1] = kNaN;
  EXPECT_EQ(pose_nees(e, j.P, solver).dof, -1);
}

}  // namespace
}  // namespace credence::internal
