#include "core/filters/estimators/ekf_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

constexpr LandmarkSensorKind kEkfSensors[] = {LandmarkSensorKind::relative_position,
                                              LandmarkSensorKind::range_bearing};
constexpr VehicleKind kEkfVehicles[] = {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car};

TEST(EkfEstimator, predicts_by_the_jacobians_of_every_vehicle) {
  for (const VehicleKind vehicle : kEkfVehicles) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing, vehicle);
    EkfEstimator filter(tour.settings);
    tour.warm(filter);
    const Pose pose = filter.state().head<3>();
    const Matrix P = whole_covariance(filter);
    const Vector map = filter.state().tail(8);
    const Control read = tour.drive();
    filter.predict(read, tour.truth());

    const Matrix F = textbook_motion_jacobian(tour.settings.model, pose, read);
    const Matrix G = textbook_control_jacobian(tour.settings.model, pose, read);
    const Matrix expected = textbook_prediction(P, F, G * tour.settings.Q * G.transpose());
    EXPECT_EQ(filter.state().head<3>(), tour.settings.model.move(pose, read).pose);
    EXPECT_EQ(filter.state().tail(8), map);
    EXPECT_LT((filter.motion_jacobian() - F).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((whole_covariance(filter) - expected).cwiseAbs().maxCoeff(), 1e-11);
  }
}

TEST(EkfEstimator, corrects_by_the_jacobians_of_every_sensor) {
  for (const LandmarkSensorKind sensor : kEkfSensors) {
    EstimatorTour tour(sensor);
    EkfEstimator filter(tour.settings);
    const BeforeUpdate before(tour, filter, {1, 3, 4});
    const auto& [x, P, observations, offsets] = before;
    const UpdateResult result = filter.update(observations, tour.truth());

    const Vector nu = before.innovation(tour.settings);
    const TextbookCorrection expected(P, textbook_jacobian(tour.settings, x, offsets), nu,
                                      textbook_noise(tour.settings, 6));
    EXPECT_TRUE(result.ok);
    EXPECT_EQ(result.dof, 6);
    EXPECT_NEAR(result.nis, expected.nis, 1e-8);
    EXPECT_DOUBLE_EQ(result.trace_prior, P.trace());
    EXPECT_LT((filter.innovation() - nu).norm(), 1e-14);
    EXPECT_LT((filter.innovation_covariance() - expected.S).norm(), 1e-10);
    EXPECT_LT((filter.gain() - expected.K).norm(), 1e-9);
    EXPECT_LT((filter.state() - x - expected.delta).norm(), 1e-9);
    EXPECT_LT((whole_covariance(filter) - expected.P).norm(), 1e-10);
  }
}

TEST(EkfEstimator, places_a_landmark_with_all_its_correlations) {
  for (const LandmarkSensorKind sensor : kEkfSensors) {
    EstimatorTour tour(sensor);
    EkfEstimator filter(tour.settings);
    const BeforeUpdate before(tour, filter, {2});
    const Vector& x = before.x;
    const Matrix& P = before.P;
    const UpdateResult result = filter.update(before.observations, tour.truth());
    EXPECT_EQ(result.initialised, 1);
    EXPECT_EQ(result.dof, 0);

    const Vector pose = x.head<3>(), z = before.observations.front().z;
    const auto of_pose = [&](const Vector& at) { return textbook_place(tour.settings, at, z); };
    const auto of_z = [&](const Vector& at) { return textbook_place(tour.settings, pose, at); };
    const Matrix J_r = numerical_jacobian(of_pose, pose), J_z = numerical_jacobian(of_z, z);
    ASSERT_EQ(filter.size(), x.size() + 2);
    EXPECT_EQ(filter.offset_of(2), x.size());
    EXPECT_LT((filter.state().tail<2>() - of_pose(pose)).norm(), 1e-14);
    EXPECT_EQ(filter.state().head(x.size()), x);
    EXPECT_LT((filter.placements().front() - J_r).norm(), 1e-10);
    EXPECT_LT((whole_covariance(filter) - textbook_augmented(P, J_r, J_z, tour.settings.R)).norm(), 1e-11);
  }
}

// Over the cut of the heading nothing jumps.
TEST(EkfEstimator, does_not_see_where_angles_are_cut) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing), turned(LandmarkSensorKind::range_bearing);
  const double turn = 2.4;  // the headings of the drive then pass π
  turned.now << rotation(turn) * tour.now.head<2>(), tour.now[2] + turn;
  for (Point& l : turned.landmarks) l = (rotation(turn) * l).eval();
  EkfEstimator here(tour.settings), there(turned.settings);
  here.reset(tour.now, 0.01 * Eigen::Matrix3d::Identity());
  there.reset(turned.now, 0.01 * Eigen::Matrix3d::Identity());
  bool passed = false;
  for (int k = 0; k < 10; ++k) {
    here.predict(tour.drive(), tour.truth());
    there.predict(turned.drive(), turned.truth());
    const double nis = here.update(tour.see({0, 1, 2, 3, 4}), tour.truth()).nis;
    EXPECT_NEAR(there.update(turned.see({0, 1, 2, 3, 4}), turned.truth()).nis, nis, 1e-8);
    EXPECT_NEAR(wrap_angle(there.state()[2] - here.state()[2] - turn), 0.0, 1e-10);
    EXPECT_LE(std::abs(there.state()[2]), std::numbers::pi);
    passed = passed || there.state()[2] < 0.0;
  }
  EXPECT_TRUE(passed);
}

}  // namespace
}  // namespace credence::internal
