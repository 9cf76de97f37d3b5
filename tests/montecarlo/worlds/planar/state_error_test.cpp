#include "montecarlo/worlds/planar/state_error.h"

#include <gtest/gtest.h>

#include <numbers>

namespace credence::internal {
namespace {

const std::vector<Point> kPlaces = {{1.0, 2.0}, {-3.0, 4.0}, {5.0, -6.0}};

TEST(TrueState, is_the_pose_and_the_landmarks_in_their_order) {
  const std::vector<int> order = {2, 0};
  EXPECT_EQ(true_state({7.0, 8.0, 0.5}, kPlaces, order), (Vector{{7.0, 8.0, 0.5, 5.0, -6.0, 1.0, 2.0}}));
  EXPECT_EQ(true_state({7.0, 8.0, 0.5}, kPlaces, {}), (Vector{{7.0, 8.0, 0.5}}));
}

// Errors (0.1, −0.2), 0.02 rad over the wrap, and (0.3, 0.4) of landmark 2; variances 0.01, 0.04, 1e-4, 1.
TEST(StateError, is_the_estimate_less_the_truth_with_the_heading_wrapped) {
  const std::vector<int> order = {2};
  const Pose pose(7.0, 8.0, std::numbers::pi - 0.01);
  const Vector x = Vector{{7.1, 7.8, -std::numbers::pi + 0.01, 5.3, -5.6}};
  const Matrix P = Vector{{0.01, 0.04, 1e-4, 1.0, 1.0}}.asDiagonal();
  StateError error;
  ASSERT_EQ(error.compute(pose, kPlaces, x, P, order), Outcome::ok);
  const Vector expected = Vector{{0.1, -0.2, 0.02, 0.3, 0.4}};
  EXPECT_LT((error.error - expected).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(error.nees, 1.0 + 1.0 + 4.0 + 0.25, 1e-10);
  EXPECT_EQ(error.dof, 5);
  EXPECT_NEAR(error.vehicle_nees, 6.0, 1e-10);
  PlanarStep step;
  error.put_into(step);
  EXPECT_EQ(step.nees, error.nees);
  EXPECT_EQ(step.nees_dof, 5);
  EXPECT_EQ(step.vehicle_nees, error.vehicle_nees);
  EXPECT_NEAR(step.position_error_squared, 0.05, 1e-14);
  EXPECT_NEAR(step.heading_error_squared, 4e-4, 1e-15);
  EXPECT_NEAR(step.map_error_squared, 0.25, 1e-14);
  EXPECT_EQ(step.landmarks, 1);
}

TEST(StateError, beyond_ten_kilometres_is_divergence_of_vehicle_and_map) {
  const std::vector<int> order = {0};
  const Matrix P = Matrix::Identity(5, 5);
  StateError error;
  for (const Index state : {0, 1, 3, 4}) {
    for (const double sign : {1.0, -1.0}) {
      Vector x = Vector{{0.0, 0.0, 0.0, 1.0, 2.0}};
      x[state] += sign * 9'999.0;
      EXPECT_EQ(error.compute(Pose::Zero(), kPlaces, x, P, order), Outcome::ok);
      x[state] += sign * 2.0;
      EXPECT_EQ(error.compute(Pose::Zero(), kPlaces, x, P, order), Outcome::diverged);
    }
  }
}

TEST(StateError, an_indefinite_covariance_is_no_covariance) {
  const std::vector<int> order = {0};
  const Vector x = Vector{{0.0, 0.0, 0.0, 1.0, 2.0}};
  StateError error;
  Matrix P = Matrix::Identity(5, 5);
  P(4, 3) = P(3, 4) = 1.5;
  EXPECT_EQ(error.compute(Pose::Zero(), kPlaces, x, P, order), Outcome::not_positive_definite);
  P = Matrix::Identity(5, 5);
  P(1, 0) = P(0, 1) = 1.5;
  EXPECT_EQ(error.compute(Pose::Zero(), kPlaces, x, P, order), Outcome::not_positive_definite);
  P = Vector{{0.0, 0.0, 0.0, 1.0, 1.0}}.asDiagonal();
  EXPECT_EQ(error.compute(Pose::Zero(), kPlaces, x, P, order), Outcome::ok) << "an exact start is legal";
  EXPECT_EQ(error.dof, 2);
}

}  // namespace
}  // namespace credence::internal
