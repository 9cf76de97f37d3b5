#include "core/filters/estimators/iterated_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence {
namespace {

/// Of ½ (x − x̂)ᵀ P⁻¹ (x − x̂) + ½ νᵀ R⁻¹ ν, over the size of its second part.
double gradient_at(const Vector& x, const EstimatorSettings& settings, const BeforeUpdate& before) {
  const Vector nu = textbook_innovation(settings, stacked(before.sights),
                                        textbook_measurement(settings, x, before.offsets));
  const Matrix H = textbook_jacobian(settings, x, before.offsets);
  const Vector of_sights = H.transpose() * textbook_noise(settings, nu.size()).llt().solve(nu);
  return (before.P.llt().solve(x - before.x) - of_sights).norm() / of_sights.norm();
}

// The minimum of the quadratic prior and the measurements' squares, where the gradient is zero, and P⁺ the
// inverse of Gauss-Newton's matrix; after at most ten iterations that settle linearly. The EKF's single step
// is far from it.
TEST(IteratedEstimator, ends_at_the_most_probable_state) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    EstimatorTour tour(sensor);
    IteratedEstimator filter(tour.settings);
    const BeforeUpdate before(tour, filter, {1, 3, 4});
    ASSERT_TRUE(filter.update(before.sights, tour.truth()).ok);

    const Vector x = filter.state();
    EXPECT_LT(gradient_at(x, tour.settings, before), 1e-4);
    const Matrix H = textbook_jacobian(tour.settings, x, before.offsets),
                 R = textbook_noise(tour.settings, 6);
    const Matrix information = before.P.inverse() + H.transpose() * R.llt().solve(H);
    EXPECT_LT((whole_covariance(filter) - information.inverse()).norm(), 1e-3 * before.P.norm());

    Vector once = before.x;
    Matrix P = before.P;
    textbook_correct(tour.settings, before.sights, before.offsets, before.x, once, P);
    EXPECT_GT(gradient_at(once, tour.settings, before), 1e-2);
  }
}

// A bearing of 3.1 and one of −3.1 are 0.08 apart, at every iteration.
TEST(IteratedEstimator, wraps_the_bearing_at_every_iteration) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.landmarks = {{-4.0, 0.02}, {-5.0, 3.0}, {3.0, 2.0}, {1.0, -4.0}, {-3.0, -2.0}};
  tour.now = tour.before = Pose(0.0, 0.0, 0.0);
  IteratedEstimator filter(tour.settings);
  filter.reset(Pose(0.05, -0.1, 0.03), EstimatorTour::initial_covariance());
  filter.update(tour.see_exactly({0, 1, 2, 3}), tour.truth());
  tour.settings.Q.setZero();
  for (int k = 0; k < 3; ++k) {
    const auto seen = tour.see({0, 1, 2, 3});
    filter.predict(Control::Zero(), tour.truth());
    ASSERT_TRUE(filter.update(seen, tour.truth()).ok);
    EXPECT_LT((filter.state().head<3>() - tour.now).norm(), 0.5);
    EXPECT_LT(filter.innovation().cwiseAbs().maxCoeff(), 0.5);
  }
}

}  // namespace
}  // namespace credence
