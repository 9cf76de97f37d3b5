#include "core/filters/estimators/schmidt_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// One correction with zeros in the gain of what is considered; P by Joseph's form, which holds for any gain.
void consider(const EstimatorSettings& settings, const EstimatorTour::Observations& observations,
              std::span<const Index> offsets, std::span<const Index> considered, Vector& x, Matrix& P) {
  const Vector nu =
      textbook_innovation(settings, stacked(observations), textbook_measurement(settings, x, offsets));
  const Matrix H = textbook_jacobian(settings, x, offsets), R = textbook_noise(settings, nu.size());
  Matrix K = TextbookCorrection(P, H, nu, R).K;
  for (const Index l : considered) K.middleRows(l, 2).setZero();
  const Matrix T = Matrix::Identity(P.rows(), P.cols()) - K * H;
  x += K * nu;
  P = (T * P * T.transpose() + K * R * K.transpose()).eval();
}

// A landmark is placed at its first observation and estimated at `active_sights` more.
TEST(SchmidtEstimator, considers_a_landmark_after_its_observations) {
  for (const Index active : {0, 1, 2}) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing);
    tour.settings.active_sights = active;
    SchmidtEstimator filter(tour.settings);
    filter.reset(tour.now + Pose(0.15, -0.1, 0.06), EstimatorTour::initial_covariance());
    std::vector<Index> observations(5, 0);  // after the first, by number
    Index steps_with_both = 0;
    for (const auto& numbers : {std::vector<int>{3, 0}, {0, 1}, {1, 0, 3}, {0, 3, 1}, {3, 4}, {4, 0, 1}}) {
      filter.predict(tour.drive(), tour.truth());
      Vector x = filter.state();
      Matrix P = whole_covariance(filter);
      const auto [known, fresh] = known_and_fresh(filter, tour.see(numbers));
      std::vector<Index> considered;
      for (const auto& observation : known) ++observations[static_cast<std::size_t>(observation.landmark)];
      for (const int number : filter.landmarks()) {
        if (observations[static_cast<std::size_t>(number)] > active)
          considered.push_back(filter.offset_of(number));
      }
      if (!known.empty()) consider(tour.settings, known, offsets_of(filter, known), considered, x, P);
      const Matrix before = whole_covariance(filter);
      const Vector stood = filter.state();
      // the known ones first, which is all that is compared here
      ASSERT_TRUE(filter.update(known, tour.truth()).ok);
      EXPECT_LT((filter.state() - x).norm(), 1e-9) << active;
      EXPECT_LT((whole_covariance(filter) - P).norm(), 1e-10) << active;
      for (const Index l : considered) {
        EXPECT_EQ(filter.state().segment<2>(l), stood.segment<2>(l));
        EXPECT_EQ(whole_covariance(filter)(l, l), before(l, l));
        if (!known.empty()) EXPECT_TRUE(filter.gain().middleRows(l, 2).isZero(0.0));
      }
      if (!considered.empty() && 2 * std::ssize(considered) < filter.size() - 3) ++steps_with_both;
      filter.update(fresh, tour.truth());
    }
    EXPECT_GT(steps_with_both, 0) << active;
  }
}

// A new run begins to count anew.
TEST(SchmidtEstimator, forgets_its_observations_when_it_is_reset) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.settings.active_sights = 2;
  SchmidtEstimator used(tour.settings), fresh(tour.settings);
  EstimatorTour first = tour;
  used.reset(first.now, EstimatorTour::initial_covariance());
  for (int k = 0; k < 6; ++k) used.update(first.see({0, 1, 2, 3}), first.truth());
  EstimatorTour again = tour;
  tour.warm(used);
  again.warm(fresh);
  EXPECT_EQ(Vector(used.state()), Vector(fresh.state()));
  EXPECT_EQ(whole_covariance(used), whole_covariance(fresh));
}

}  // namespace
}  // namespace credence::internal
