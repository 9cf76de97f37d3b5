#include "core/filters/estimators/slam_estimator.h"

#include <gtest/gtest.h>

#include "core/filters/estimators/estimators.h"
#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

std::unique_ptr<SlamEstimator> estimator_of(const EstimatorKind& kind, const EstimatorTour& tour) {
  return kind.make(tour.settings);
}

// What every estimator shares, whatever it linearises.
TEST(SlamEstimator, judges_as_it_would_update) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing);
    const auto used = estimator_of(kind, tour), judge = estimator_of(kind, tour);
    EstimatorTour same = tour;
    const BeforeUpdate before(tour, *used, {1, 0, 2});
    const BeforeUpdate other(same, *judge, {1, 0, 2});
    const UpdateResult updated = used->update(before.observations, tour.truth());
    const UpdateResult judged = judge->judge(other.observations, same.truth());
    EXPECT_EQ(judged.ok, updated.ok) << kind.name;
    EXPECT_EQ(judged.dof, 4) << kind.name;
    EXPECT_EQ(judged.nis, updated.nis) << kind.name;
    EXPECT_EQ(Vector(judge->innovation()), Vector(used->innovation())) << kind.name;
    EXPECT_EQ(Matrix(judge->innovation_covariance()), Matrix(used->innovation_covariance())) << kind.name;
    EXPECT_EQ(updated.initialised, 1) << kind.name;
    EXPECT_EQ(judge->offset_of(2), -1) << kind.name;  // no first observations
    EXPECT_EQ(used->offset_of(2), used->size() - 2) << kind.name;
  }
}

// A run depends on nothing of the run before: same bits.
TEST(SlamEstimator, starts_anew_when_it_is_reset) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing);
    const auto used = estimator_of(kind, tour), fresh = estimator_of(kind, tour);
    EstimatorTour first(LandmarkSensorKind::range_bearing, VehicleKind::unicycle, 7), same = tour;
    first.warm(*used);
    tour.warm(*used);
    same.warm(*fresh);
    EXPECT_EQ(Vector(used->state()), Vector(fresh->state())) << kind.name;
    EXPECT_EQ(whole_covariance(*used), whole_covariance(*fresh)) << kind.name;
    EXPECT_EQ(std::vector(used->landmarks().begin(), used->landmarks().end()), (std::vector<int>{3, 0, 1, 4}))
        << kind.name;
  }
}

// The order of observations in a batch is of no consequence to the estimate.
TEST(SlamEstimator, takes_a_batch_in_any_order) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    if (kind.name == "intersection") continue;  // one landmark after the other
    EstimatorTour tour(LandmarkSensorKind::range_bearing);
    const auto one = estimator_of(kind, tour), other = estimator_of(kind, tour);
    EstimatorTour same = tour;
    const BeforeUpdate before(tour, *one, {0, 1, 4});
    const BeforeUpdate again(same, *other, {0, 1, 4});
    auto turned = before.observations;
    std::swap(turned[0], turned[2]);
    const double nis = one->update(before.observations, tour.truth()).nis;
    EXPECT_NEAR(other->update(turned, same.truth()).nis, nis, 1e-7 * nis) << kind.name;
    EXPECT_LT((one->state() - other->state()).norm(), 1e-8) << kind.name;
    EXPECT_LT((whole_covariance(*one) - whole_covariance(*other)).norm(), 1e-8) << kind.name;
  }
}

// Along a straight line; the mean of sigma points falls short of it by the spread of the heading, some mm.
TEST(SlamEstimator, refuses_a_landmark_twice_in_a_batch) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  EkfEstimator filter(tour.settings);
  tour.warm(filter);
  const Vector x = filter.state();
  for (const int number : {3, 2}) {  // known, and not known yet
    EXPECT_THROW(filter.update(tour.see({0, number, 1, number}), tour.truth()), std::invalid_argument);
    EXPECT_EQ(filter.state(), x);
  }
}

TEST(SlamEstimator, predicts_by_the_interval_that_was_set) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing);
    const auto filter = estimator_of(kind, tour);
    tour.warm(*filter);
    const Vector x = filter->state();
    filter->set_interval(0.125);
    filter->predict(Control(2.0, 0.0), tour.truth());
    EXPECT_NEAR((filter->state().head<2>() - x.head<2>()).norm(), 0.25, 0.01) << kind.name;
    filter->set_interval(0.5);
    filter->predict(Control(2.0, 0.0), tour.truth());
    EXPECT_NEAR((filter->state().head<2>() - x.head<2>()).norm(), 1.25, 0.01) << kind.name;
  }
}

// W and L of the correction make K, with which x moved from what ν was taken at.
TEST(SlamEstimator, has_the_gain_of_its_last_correction) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  const auto filter = make_estimator("ekf", tour.settings);
  tour.warm(*filter);
  filter->predict(tour.drive(), tour.truth());
  const Matrix P = whole_covariance(*filter);
  filter->update(tour.see({0, 2}), tour.truth());
  const Matrix H = filter->measurement_jacobian();
  EXPECT_EQ(filter->gain().rows(), P.rows());  // as it was before landmark 2 was placed
  Matrix H_whole = Matrix::Zero(2, P.rows());
  for (Index j = 0; j < H.cols(); ++j) H_whole.col(filter->seen()[static_cast<std::size_t>(j)]) = H.col(j);
  const Matrix K = P * H_whole.transpose() * Matrix(filter->innovation_covariance()).inverse();
  EXPECT_LT((filter->gain() - K).norm(), 1e-10);
  ASSERT_EQ(filter->placements().size(), 1U);

  filter->update({}, tour.truth());
  EXPECT_EQ(filter->gain().cols(), 0);
  EXPECT_EQ(filter->placements().size(), 0U);
}

}  // namespace
}  // namespace credence::internal
