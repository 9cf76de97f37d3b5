#include "core/filters/estimators/ideal_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// The truth in the order of a filter's state.
Vector ideal_true_state(const EstimatorTour& tour, const SlamEstimator& filter) {
  Vector x(filter.size());
  x.head<3>() = tour.now;
  for (const int number : filter.landmarks()) {
    x.segment<2>(filter.offset_of(number)) = tour.landmarks[static_cast<std::size_t>(number)];
  }
  return x;
}

TEST(IdealEstimator, predicts_by_the_jacobians_at_the_truth) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  IdealEstimator filter(tour.settings);
  tour.warm(filter);
  const Pose pose = filter.state().head<3>();
  const Matrix P = whole_covariance(filter);
  const Control read = tour.drive();
  filter.predict(read, tour.truth());

  const Matrix F = textbook_motion_jacobian(tour.settings.model, tour.before, tour.control);
  const Matrix G = textbook_control_jacobian(tour.settings.model, tour.before, tour.control);
  EXPECT_EQ(filter.state().head<3>(), tour.settings.model.move(pose, read).pose);
  EXPECT_LT((filter.motion_jacobian() - F).norm(), 1e-10);
  EXPECT_LT(
      (whole_covariance(filter) - textbook_prediction(P, F, G * tour.settings.Q * G.transpose())).norm(),
      1e-11);
}

TEST(IdealEstimator, corrects_by_the_jacobians_at_the_truth) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    EstimatorTour tour(sensor);
    IdealEstimator filter(tour.settings);
    const BeforeUpdate before(tour, filter, {4, 0});
    const auto& [x, P, observations, offsets] = before;
    filter.update(observations, tour.truth());

    const Vector nu = before.innovation(tour.settings);
    const Matrix H = textbook_jacobian(tour.settings, ideal_true_state(tour, filter), offsets);
    const TextbookCorrection expected(P, H, nu, textbook_noise(tour.settings, 4));
    EXPECT_LT((filter.state() - x - expected.delta).norm(), 1e-9);
    EXPECT_LT((whole_covariance(filter) - expected.P).norm(), 1e-10);
  }
}

TEST(IdealEstimator, places_a_landmark_by_the_jacobians_at_the_truth) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  IdealEstimator filter(tour.settings);
  tour.warm(filter);
  const Pose pose = filter.state().head<3>();
  const Matrix P = whole_covariance(filter);
  const auto observations = tour.see({2});
  filter.update(observations, tour.truth());

  const Vector z = tour.settings.sensor.measure(rotation(tour.now[2]).transpose() *
                                                (tour.landmarks[2] - tour.now.head<2>()));
  const Matrix J_r =
      numerical_jacobian([&](const Vector& at) { return textbook_place(tour.settings, at, z); }, tour.now);
  const Matrix J_z =
      numerical_jacobian([&](const Vector& at) { return textbook_place(tour.settings, tour.now, at); }, z);
  EXPECT_LT((filter.state().tail<2>() - textbook_place(tour.settings, pose, observations.front().z)).norm(),
            1e-14);
  EXPECT_LT((whole_covariance(filter) - textbook_augmented(P, J_r, J_z, tour.settings.R)).norm(), 1e-10);
}

// Its P is that of a linear problem: it depends on the truth alone, not on the noise.
TEST(IdealEstimator, has_a_covariance_that_no_noise_changes) {
  EstimatorTour one(LandmarkSensorKind::range_bearing, VehicleKind::unicycle, 1);
  EstimatorTour other(LandmarkSensorKind::range_bearing, VehicleKind::unicycle, 2);
  IdealEstimator a(one.settings), b(other.settings);
  one.warm(a);
  other.warm(b);
  EXPECT_GT((a.state() - b.state()).norm(), 1e-2);
  EXPECT_LT((whole_covariance(a) - whole_covariance(b)).norm(), 1e-12);
}

}  // namespace
}  // namespace credence::internal
