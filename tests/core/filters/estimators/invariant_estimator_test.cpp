#include "core/filters/estimators/invariant_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"
#include "tests/core/filters/estimators/se_group.h"

namespace credence::internal {
namespace {

constexpr InvariantReset kInvariantResets[] = {InvariantReset::right, InvariantReset::left,
                                               InvariantReset::full};

// The motion is a product from the right: log(X̂ X⁻¹) stays what it is, however large, for every control that
// is read as it was.
TEST(InvariantEstimator, keeps_its_error_through_an_exact_motion) {
  for (const VehicleKind vehicle : {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car}) {
    EstimatorTour tour(LandmarkSensorKind::relative_position, vehicle);
    InvariantEstimator filter(tour.settings);
    tour.warm(filter);
    filter.predict(Control(0.5, 0.4), tour.truth());  // the truth stands: a large error
    Vector before(filter.size()), after(filter.size());
    filter.error(tour.truth(), before);
    EXPECT_GT(before.head<3>().norm(), 0.1);
    for (int k = 0; k < 30; ++k) {
      tour.drive_exactly();
      filter.predict(tour.control, tour.truth());
    }
    filter.error(tour.truth(), after);
    EXPECT_LT((after - before).norm(), 1e-12);
  }
}

TEST(InvariantEstimator, error_is_the_logarithm_in_the_group) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  InvariantEstimator filter(tour.settings);
  tour.warm(filter);
  Vector truth(filter.size()), error(filter.size());
  truth.head<3>() = tour.now;
  for (const int i : filter.landmarks()) {
    truth.segment<2>(filter.offset_of(i)) = tour.landmarks[static_cast<std::size_t>(i)];
  }
  filter.error(tour.truth(), error);
  EXPECT_LT((GroupMatrix::moved(truth, error) - filter.state()).norm(), 1e-12);
  EXPECT_EQ(filter.chart(), ErrorChart::right_invariant);
}

TEST(InvariantEstimator, predicts_with_the_noise_of_the_control_in_its_chart) {
  for (const VehicleKind vehicle : {VehicleKind::unicycle, VehicleKind::car}) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing, vehicle);
    InvariantEstimator filter(tour.settings);
    tour.warm(filter);
    const Vector x = filter.state();
    const Matrix P = whole_covariance(filter);
    const Control read = tour.drive();
    filter.predict(read, tour.truth());

    const Vector here = filter.state();
    const Matrix G = numerical_jacobian(
        [&](const Vector& u) {
          Vector there = x;
          there.head<3>() = tour.settings.model.move(x.head<3>(), Control(u)).pose;
          return GroupMatrix::apart(there, here);
        },
        read);
    EXPECT_LT((whole_covariance(filter) - P - G * tour.settings.Q * G.transpose()).norm(), 1e-10);
  }
}

TEST(InvariantEstimator, corrects_in_the_group_and_moves_its_covariance_as_asked) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const InvariantReset reset : kInvariantResets) {
      EstimatorTour tour(sensor);
      InvariantEstimator filter(tour.settings, reset);
      const BeforeUpdate before(tour, filter, {4, 3});
      const Vector& x = before.x;
      const Matrix& P = before.P;
      const auto& observations = before.observations;
      const auto& offsets = before.offsets;
      ASSERT_TRUE(filter.update(observations, tour.truth()).ok);

      const Vector z = textbook_measurement(tour.settings, x, offsets);
      const auto of_error = [&](const Vector& xi) {
        return textbook_innovation(
            tour.settings, textbook_measurement(tour.settings, GroupMatrix::moved(x, xi), offsets), z);
      };
      const Vector zero = Vector::Zero(x.size());
      const TextbookCorrection expected(P, numerical_jacobian(of_error, zero),
                                        textbook_innovation(tour.settings, stacked(observations), z),
                                        textbook_noise(tour.settings, 4));
      const Vector delta = expected.delta;
      EXPECT_GT(std::abs(delta[2]), 5e-4);
      EXPECT_LT((filter.state() - GroupMatrix::moved(x, delta)).norm(), 1e-9);
      Matrix T = Matrix::Identity(x.size(), x.size());
      const Vector moved = GroupMatrix::state(GroupMatrix::exponential(delta));
      if (reset == InvariantReset::left) T = GroupMatrix::adjoint(moved);
      if (reset == InvariantReset::full) {
        T = numerical_jacobian(
            [&](const Vector& e) {
              return GroupMatrix::apart(GroupMatrix::state(GroupMatrix::exponential(delta + e)), moved);
            },
            zero);
      }
      EXPECT_LT((whole_covariance(filter) - T * expected.P * T.transpose()).norm(), 1e-9);
    }
  }
}

TEST(InvariantEstimator, places_a_landmark_in_its_chart) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  InvariantEstimator filter(tour.settings);
  tour.warm(filter);
  const Vector x = filter.state();
  const Matrix P = whole_covariance(filter);
  const auto observations = tour.see({2});
  filter.update(observations, tour.truth());

  const Vector z = observations.front().z, here = filter.state();
  const auto placed = [&](const Vector& at, const Vector& seen) {
    Vector with(at.size() + 2);
    with << at, textbook_place(tour.settings, at.head<3>(), seen);
    return GroupMatrix::apart(with, here);
  };
  const Vector zero = Vector::Zero(x.size());
  const Matrix T =
      numerical_jacobian([&](const Vector& xi) { return placed(GroupMatrix::moved(x, xi), z); }, zero);
  const Matrix J_z = numerical_jacobian([&](const Vector& seen) { return placed(x, seen); }, z);
  const Matrix expected = T * P * T.transpose() + J_z * tour.settings.R * J_z.transpose();
  EXPECT_LT((whole_covariance(filter) - expected).norm(), 1e-10);
}

TEST(InvariantEstimator, says_its_covariance_in_the_plane) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  InvariantEstimator filter(tour.settings);
  filter.reset(tour.now, EstimatorTour::initial_covariance());
  EXPECT_LT((filter.plane_covariance() - EstimatorTour::initial_covariance()).norm(), 1e-15);
  tour.warm(filter);
  const Vector x = filter.state();
  const Matrix T = numerical_jacobian([&](const Vector& xi) { return GroupMatrix::moved(x, xi); },
                                      Vector(Vector::Zero(x.size())));
  const Matrix expected = T * whole_covariance(filter) * T.transpose();
  EXPECT_LT((filter.plane_covariance() - expected).norm(), 1e-10);
  EXPECT_LT((filter.plane_pose_covariance() - expected.topLeftCorner(3, 3)).norm(), 1e-10);
}

}  // namespace
}  // namespace credence::internal
