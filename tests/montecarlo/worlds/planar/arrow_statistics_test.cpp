#include "montecarlo/worlds/planar/arrow_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

/// A pose and landmarks that are correlated with it alone.
Matrix pose_and_map(Index landmarks) {
  const Index n = 3 + 2 * landmarks;
  Matrix P = Matrix::Zero(n, n);
  P.topLeftCorner<3, 3>() << 4.0, 0.5, 0.1, 0.5, 3.0, -0.2, 0.1, -0.2, 0.05;
  for (Index i = 3; i < n; i += 2) {
    const double s = static_cast<double>(i);
    P.block<2, 2>(i, i) << 2.0 + 0.1 * s, 0.3, 0.3, 1.0 + 0.2 * s;
    P.block<2, 3>(i, 0) << 0.2, 0.05 * std::cos(s), 0.01, -0.1, 0.1, 0.02 * std::sin(s);
    P.block<3, 2>(0, i) = P.block<2, 3>(i, 0).transpose();
  }
  return P;
}

// The overloads of both forms of one covariance give the same numbers, which is all that a study takes.
TEST(ArrowStatistics, are_those_of_the_dense_matrix) {
  for (const Index landmarks : {0, 1, 8, 20}) {
    const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = landmarks};
    Matrix P = pose_and_map(landmarks);
    const Vector e = Vector::LinSpaced(P.rows(), -1.0, 2.0);
    for (const bool exact_heading : {false, true}) {
      if (exact_heading) {
        P.row(2).setZero();
        P.col(2).setZero();
      }
      const ArrowCovariance arrow = ArrowCovariance::of(P, layout);
      NeesSolver solver;
      const NeesValue joint = joint_nees(e, P, solver), pose = pose_nees(e, P, solver);
      EXPECT_EQ(joint.dof, P.rows() - (exact_heading ? 1 : 0));
      EXPECT_EQ(joint_nees(e, arrow, solver).dof, joint.dof);
      EXPECT_NEAR(joint_nees(e, arrow, solver).value, joint.value, 1e-12 * joint.value);
      EXPECT_EQ(pose_nees(e, arrow, solver).dof, pose.dof);
      EXPECT_NEAR(pose_nees(e, arrow, solver).value, pose.value, 1e-12 * pose.value);
      const PlanarTraces of_arrow = planar_traces(arrow), of_matrix = planar_traces(P);
      EXPECT_NEAR(of_arrow.all, of_matrix.all, 1e-12 * of_matrix.all);
      EXPECT_EQ(of_arrow.position, 7.0);
      EXPECT_EQ(of_arrow.heading, P(2, 2));
      EXPECT_NEAR(of_arrow.landmarks, of_matrix.landmarks, 1e-12 * of_matrix.all);
      EXPECT_EQ(dense_covariance(arrow), P);
    }
  }
}

TEST(ArrowStatistics, an_indefinite_arrow_has_no_nees) {
  Matrix P = pose_and_map(4);
  P.block<2, 3>(5, 0) *= 40.0;
  P.block<3, 2>(0, 5) *= 40.0;
  NeesSolver solver;
  const Vector e = Vector::Ones(P.rows());
  ASSERT_EQ(joint_nees(e, P, solver).dof, -1);
  const ArrowCovariance arrow = ArrowCovariance::of(P, {.vehicle = 3, .landmark = 2, .landmarks = 4});
  EXPECT_EQ(joint_nees(e, arrow, solver).dof, -1);
  EXPECT_EQ(pose_nees(e, arrow, solver).dof, 3) << "of the pose alone it is one";
}

}  // namespace
}  // namespace credence::internal
