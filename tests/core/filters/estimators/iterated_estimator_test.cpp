#include "core/filters/estimators/iterated_estimator.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/manifold/rotation.h"
#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

struct IteratedCorrection {
  EstimatorTour tour;
  Vector prior{}, x{};
  Matrix P{};
  EstimatorTour::Observations observations{};
  std::vector<int> order{};

  /// The prior's and the observations' squares at a state.
  double cost(const Vector& at) const {
    const Vector off = at - prior;
    double sum = off.dot(P.inverse() * off);
    for (const auto& observation : observations) {
      const Index l = 3 + 2 * (std::ranges::find(order, observation.landmark) - order.begin());
      const Point rho = rotation(at[2]).transpose() * (at.segment<2>(l) - at.head<2>());
      const Eigen::Vector2d nu =
          tour.settings.sensor.innovation(observation.z, tour.settings.sensor.measure(rho));
      sum += nu.dot(tour.settings.R.inverse() * nu);
    }
    return sum;
  }
};

/// The correction after a turn that no control told, by a sensor of `noise` times the variances of the
/// tour's.
IteratedCorrection after_turn(LandmarkSensorKind kind, double turn_rad, double noise) {
  IteratedCorrection c{.tour = EstimatorTour(kind)};
  c.tour.settings.R *= noise;
  IteratedEstimator filter(c.tour.settings);
  filter.reset(c.tour.now, EstimatorTour::initial_covariance());
  for (int k = 0; k < 4; ++k) {
    filter.predict(c.tour.drive(), c.tour.truth());
    filter.update(c.tour.see({0, 1, 2}), c.tour.truth());
  }
  filter.predict(c.tour.drive(), c.tour.truth());
  c.tour.now[2] += turn_rad;
  c.prior = filter.state();
  c.P = filter.covariance().selfadjointView<Eigen::Lower>();
  c.order.assign(filter.landmarks().begin(), filter.landmarks().end());
  c.observations = c.tour.see({0, 1, 2});
  filter.update(c.observations, c.tour.truth());
  c.x = filter.state();
  return c;
}

/// Of ½ (x − x̂)ᵀ P⁻¹ (x − x̂) + ½ νᵀ R⁻¹ ν, over the size of its second part.
double gradient_at(const Vector& x, const EstimatorSettings& settings, const BeforeUpdate& before) {
  const Vector nu = textbook_innovation(settings, stacked(before.observations),
                                        textbook_measurement(settings, x, before.offsets));
  const Matrix H = textbook_jacobian(settings, x, before.offsets);
  const Vector of_observations = H.transpose() * textbook_noise(settings, nu.size()).llt().solve(nu);
  return (before.P.llt().solve(x - before.x) - of_observations).norm() / of_observations.norm();
}

// The minimum of the quadratic prior and the measurements' squares, where the gradient is zero, and P⁺ the
// inverse of Gauss-Newton's matrix. The EKF's single step is far from it.
TEST(IteratedEstimator, ends_at_the_most_probable_state) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    EstimatorTour tour(sensor);
    IteratedEstimator filter(tour.settings);
    const BeforeUpdate before(tour, filter, {1, 3, 4});
    ASSERT_TRUE(filter.update(before.observations, tour.truth()).ok);

    const Vector x = filter.state();
    EXPECT_LT(gradient_at(x, tour.settings, before), 1e-4);
    const Matrix H = textbook_jacobian(tour.settings, x, before.offsets),
                 R = textbook_noise(tour.settings, 6);
    const Matrix information = before.P.inverse() + H.transpose() * R.llt().solve(H);
    EXPECT_LT((whole_covariance(filter) - information.inverse()).norm(), 1e-3 * before.P.norm());

    Vector once = before.x;
    Matrix P = before.P;
    textbook_correct(tour.settings, before.observations, before.offsets, before.x, once, P);
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

// The minimum has no gradient: a K-free check, of cases that the first ten steps do not bring there.
TEST(IteratedEstimator, SettlesAtTheMinimumAfterATurnThatNobodyExpected) {
  for (const auto kind : {LandmarkSensorKind::range_bearing, LandmarkSensorKind::relative_position}) {
    for (const double noise : {1.0, 1e-1, 1e-2, 1e-4}) {
      for (const double turn_rad : {0.1, 0.25}) {
        const IteratedCorrection c = after_turn(kind, turn_rad, noise);
        for (Index i = 0; i < c.x.size(); ++i) {
          const double h = 1e-5;
          const Vector step = h * Vector::Unit(c.x.size(), i);
          const double up = c.cost(c.x + step), down = c.cost(c.x - step);
          const double slope = (up - down) / (2.0 * h), curvature = (up + down - 2.0 * c.cost(c.x)) / (h * h);
          EXPECT_LT(std::abs(slope), 1e-6 * curvature) << "sensor " << static_cast<int>(kind) << " noise "
                                                       << noise << " turn " << turn_rad << " state " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace credence::internal
