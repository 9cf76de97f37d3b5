#include "core/filters/estimators/ukf_manifold_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"
#include "tests/core/filters/estimators/se_group.h"
#include "tests/core/filters/estimators/weighted_points.h"

namespace credence::internal {
namespace {

constexpr double kManifoldSpreads[] = {0.3, 1.0};

// The noise of the control in the frame of the vehicle, log(X̂⁻¹ X), by its sigma points; to the error
// log(X̂ X⁻¹) of pose and landmarks by the adjoint of X̂. The mean is moved by the control alone.
TEST(UkfManifoldEstimator, predicts_by_sigma_points_of_the_control) {
  for (const VehicleKind vehicle : {VehicleKind::unicycle, VehicleKind::car}) {
    for (const double alpha : kManifoldSpreads) {
      EstimatorTour tour(LandmarkSensorKind::range_bearing, vehicle);
      tour.settings.sigma_spread = alpha;
      tour.settings.Q *= 20.0;
      UkfManifoldEstimator filter(tour.settings);
      tour.warm(filter);
      const Matrix P = whole_covariance(filter);
      const Pose from = filter.state().head<3>();
      const Control read = tour.drive();
      filter.predict(read, tour.truth());

      const Vector x = filter.state();
      const Pose here = tour.settings.model.move(from, read).pose;
      EXPECT_EQ(x.head<3>(), here);
      const WeightedPoints points(
          [&](const Vector& u) {
            const Vector moved = tour.settings.model.move(from, Control(u)).pose;
            const Matrix back = GroupMatrix::of(here).inverse() * GroupMatrix::of(moved);
            return GroupMatrix::apart(GroupMatrix::state(back), Vector::Zero(3));
          },
          read, tour.settings.Q.llt().matrixL(), alpha);
      Matrix noise = Matrix::Zero(x.size(), x.size());
      noise.topLeftCorner(3, 3) = points.covariance;
      const Matrix Ad = GroupMatrix::adjoint(x);
      const Matrix expected = P + Ad * noise * Ad.transpose();
      EXPECT_LT((whole_covariance(filter) - expected).norm(), 1e-9 * expected.norm()) << alpha;
    }
  }
}

// Points Exp(ξ) X̂ of all states that are seen; the correction is one too.
TEST(UkfManifoldEstimator, corrects_by_sigma_points_in_the_group) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const double alpha : kManifoldSpreads) {
      EstimatorTour tour(sensor);
      tour.settings.sigma_spread = alpha;
      UkfManifoldEstimator filter(tour.settings);
      const BeforeUpdate before(tour, filter, {1, 4});
      std::vector<Index> touched = {0, 1, 2};
      for (const Index l : before.offsets) touched.insert(touched.end(), {l, l + 1});
      const Vector at = before.x(touched);
      const Matrix P_seen = before.P(touched, touched);
      const std::vector<Index> places = {3, 5};
      const Vector here = textbook_measurement(tour.settings, at, places);
      const WeightedPoints points(
          [&](const Vector& xi) {
            return textbook_innovation(
                tour.settings, textbook_measurement(tour.settings, GroupMatrix::moved(at, xi), places), here);
          },
          Vector::Zero(7), P_seen.llt().matrixL(), alpha);
      const Vector nu = textbook_innovation(tour.settings, stacked(before.observations), here) - points.mean;
      const Matrix S = points.covariance + textbook_noise(tour.settings, 4);
      const Matrix cross = Matrix(before.P(Eigen::all, touched)) * P_seen.llt().solve(points.cross);
      const Matrix K = S.llt().solve(cross.transpose()).transpose();

      ASSERT_TRUE(filter.update(before.observations, tour.truth()).ok);
      EXPECT_LT((filter.innovation() - nu).norm(), 1e-10);
      EXPECT_LT((filter.innovation_covariance() - S).norm(), 1e-10);
      EXPECT_LT((filter.state() - GroupMatrix::moved(before.x, K * nu)).norm(), 1e-9);
      EXPECT_LT((whole_covariance(filter) - before.P + K * S * K.transpose()).norm(), 1e-9) << alpha;
    }
  }
}

}  // namespace
}  // namespace credence::internal
