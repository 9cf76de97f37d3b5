#include "core/filters/estimators/ukf_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"
#include "tests/core/filters/estimators/weighted_points.h"

namespace credence::internal {
namespace {

constexpr double kUkfSpreads[] = {0.3, 1.0};

/// A symmetric matrix's lower Cholesky factor.
Matrix root_of(const Matrix& P) { return P.llt().matrixL(); }

// Sigma points of pose and control, written out with their weights; the map follows by the regression of the
// pose moved on the pose before, cov(y, x) P⁻¹.
TEST(UkfEstimator, predicts_by_its_sigma_points) {
  for (const VehicleKind vehicle : {VehicleKind::unicycle, VehicleKind::bicycle, VehicleKind::car}) {
    for (const double alpha : kUkfSpreads) {
      EstimatorTour tour(LandmarkSensorKind::range_bearing, vehicle);
      tour.settings.sigma_spread = alpha;
      UkfEstimator filter(tour.settings);
      tour.warm(filter);
      const Matrix P = whole_covariance(filter);
      const Vector x = filter.state();
      const Control read = tour.drive();
      filter.predict(read, tour.truth());

      Vector both(5);
      both << x.head(3), read;
      Matrix spread = Matrix::Zero(5, 5);
      spread.topLeftCorner(3, 3) = P.topLeftCorner(3, 3);
      spread.bottomRightCorner(2, 2) = tour.settings.Q;
      const WeightedPoints points(
          [&](const Vector& at) {
            return Vector(tour.settings.model.move(Pose(at.head<3>()), Control(at.tail<2>())).pose);
          },
          both, root_of(spread), alpha);
      const Matrix regression =
          P.topLeftCorner(3, 3).llt().solve(Matrix(points.cross.topRows(3))).transpose();
      EXPECT_LT((filter.state().head(3) - points.mean).norm(), 1e-10);
      EXPECT_EQ(filter.state().tail(8), x.tail(8));
      const Matrix after = whole_covariance(filter);
      EXPECT_LT((after.topLeftCorner(3, 3) - points.covariance).norm(), 1e-10) << alpha;
      EXPECT_LT((after.topRightCorner(3, 8) - regression * P.topRightCorner(3, 8)).norm(), 1e-10) << alpha;
      EXPECT_EQ(after.bottomRightCorner(8, 8), P.bottomRightCorner(8, 8));
    }
  }
}

// A correction by the points of pose and landmarks seen: ẑ, S and cov(x, z) by their weighted sums; the other
// states by their regression on these.
TEST(UkfEstimator, corrects_by_its_sigma_points) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const double alpha : kUkfSpreads) {
      EstimatorTour tour(sensor);
      tour.settings.sigma_spread = alpha;
      UkfEstimator filter(tour.settings);
      const BeforeUpdate before(tour, filter, {1, 4});
      const Index n = filter.size();
      std::vector<Index> touched = {0, 1, 2};
      for (const Index l : before.offsets) touched.insert(touched.end(), {l, l + 1});
      const Vector at = before.x(touched);
      const Matrix P_seen = before.P(touched, touched);
      const std::vector<Index> places = {3, 5};
      const Vector here = textbook_measurement(tour.settings, at, places);
      const WeightedPoints points(
          [&](const Vector& state) {
            return textbook_innovation(tour.settings, textbook_measurement(tour.settings, state, places),
                                       here);
          },
          at, root_of(P_seen), alpha);
      const Vector nu = textbook_innovation(tour.settings, stacked(before.observations), here) - points.mean;
      const Matrix S = points.covariance + textbook_noise(tour.settings, 4);
      const Matrix of_all = before.P(Eigen::all, touched);
      const Matrix cross = of_all * P_seen.llt().solve(points.cross);
      const Matrix K = S.llt().solve(cross.transpose()).transpose();

      const UpdateResult result = filter.update(before.observations, tour.truth());
      ASSERT_TRUE(result.ok);
      EXPECT_LT((filter.innovation() - nu).norm(), 1e-10);
      EXPECT_LT((filter.innovation_covariance() - S).norm(), 1e-10);
      EXPECT_NEAR(result.nis, nu.dot(S.llt().solve(nu)), 1e-8);
      EXPECT_LT((filter.gain() - K).norm(), 1e-8);
      EXPECT_LT((filter.state() - before.x - K * nu).norm(), 1e-9);
      EXPECT_LT((whole_covariance(filter) - before.P + K * S * K.transpose()).norm(), 1e-9) << n;
    }
  }
}

// A heading at π: points beyond it come back on the other side, and their mean is no average of both.
TEST(UkfEstimator, has_no_seam_at_pi) {
  for (const double alpha : kUkfSpreads) {
    Vector states[2];
    Matrix covariances[2];
    for (const bool turned : {false, true}) {
      EstimatorTour tour(LandmarkSensorKind::range_bearing);
      tour.settings.sigma_spread = alpha;
      // The same world turned by half a turn.
      if (turned) {
        for (Point& l : tour.landmarks) l = -l;
        tour.now = tour.before = Pose(-0.5, 1.0, wrap_angle(0.3 + M_PI));
      }
      UkfEstimator filter(tour.settings);
      Matrix P0 = EstimatorTour::initial_covariance();
      P0(2, 2) = 0.3;  // points on both sides of the seam, 0.3 away
      if (turned) P0.topRightCorner(2, 1) *= -1.0, P0.bottomLeftCorner(1, 2) *= -1.0;
      filter.reset(tour.now, P0);
      filter.update(tour.see_exactly({0, 1, 2, 3, 4}), tour.truth());
      for (int k = 0; k < 4; ++k) {
        tour.drive_exactly();
        filter.predict(tour.control, tour.truth());
        ASSERT_TRUE(filter.update(tour.see_exactly({0, 2, 3}), tour.truth()).ok);
      }
      Vector x = filter.state();
      Vector sign = Vector::Constant(x.size(), turned ? -1.0 : 1.0);
      sign[2] = 1.0;
      if (turned) x[2] = wrap_angle(x[2] - M_PI);
      states[turned] = sign.cwiseProduct(x);
      covariances[turned] = sign.asDiagonal() * whole_covariance(filter) * sign.asDiagonal();
    }
    EXPECT_LT((states[0] - states[1]).norm(), 1e-9) << alpha;
    EXPECT_LT((covariances[0] - covariances[1]).norm(), 1e-9) << alpha;
  }
}

}  // namespace
}  // namespace credence::internal
