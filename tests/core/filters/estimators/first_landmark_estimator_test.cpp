#include "core/filters/estimators/first_landmark_estimator.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// The EKF, with the places that the base class keeps to be seen and a turn about any point.
class FirstPlaces final : public FirstLandmarkEstimator {
 public:
  using FirstLandmarkEstimator::FirstLandmarkEstimator;

  Point first(int number) const { return first_landmark(offset_of(number)); }
  Point turn{0.0, 0.0};

 private:
  void propagate(const Pose& before, const Motion& motion, const Control&, const PlanarTruth&) override {
    propagate_pose(plane_motion(before.head<2>(), motion.pose.head<2>()),
                   motion.G * settings().Q * motion.G.transpose());
  }
  void linearise(const PlanarTruth&) override {
    set_plane_rows(pose(), [this](Index offset) { return landmark(offset); });
  }
  Point turned_about() const override { return turn; }
};

Point place_in_state(const FirstPlaces& filter, int number) {
  return filter.state().segment<2>(filter.offset_of(number));
}

// A landmark is corrected by what is seen later; where it was put first is remembered, by its own number.
TEST(FirstLandmarkEstimator, keeps_where_every_landmark_was_put) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  FirstPlaces filter(tour.settings);
  filter.reset(tour.now + Pose(0.15, -0.1, 0.06), EstimatorTour::initial_covariance());
  std::vector<Point> put(tour.landmarks.size());
  for (const auto& numbers : {std::vector<int>{3, 0}, {0, 3, 1}, {4, 3}, {1, 0, 4}}) {
    filter.predict(tour.drive(), tour.truth());
    std::vector<int> fresh;
    for (const int number : numbers) {
      if (filter.offset_of(number) < 0) fresh.push_back(number);
    }
    ASSERT_TRUE(filter.update(tour.see(numbers), tour.truth()).ok);
    for (const int number : fresh) put[static_cast<std::size_t>(number)] = place_in_state(filter, number);
  }
  for (const int number : {3, 0, 1, 4}) {
    EXPECT_EQ(filter.first(number), put[static_cast<std::size_t>(number)]) << number;
    if (number == 4) continue;
    EXPECT_GT((place_in_state(filter, number) - filter.first(number)).norm(), 1e-4) << "corrected since";
  }
}

// δl = [I, J (l − c)] δx_r + J_z w, c the point of the turn: the columns of P that it makes, and its block.
TEST(FirstLandmarkEstimator, places_by_a_turn_about_its_own_point) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const Point& turn : {Point(0.0, 0.0), Point(3.0, -2.0)}) {
      EstimatorTour tour(sensor);
      FirstPlaces filter(tour.settings);
      filter.turn = turn;
      filter.reset(tour.now, EstimatorTour::initial_covariance());
      Vector x = filter.state();
      Matrix P = EstimatorTour::initial_covariance();
      const auto seen = tour.see({2});
      ASSERT_TRUE(filter.update(seen, tour.truth()).ok);
      const Point l = textbook_start(tour.settings, seen[0].z, turn, x, P);
      EXPECT_LT((place_in_state(filter, 2) - l).norm(), 1e-12);
      EXPECT_LT((whole_covariance(filter) - P).norm(), 1e-8);
      Eigen::Matrix<double, 2, 3> expected;
      expected << 1.0, 0.0, -(l - turn)[1], 0.0, 1.0, (l - turn)[0];
      ASSERT_EQ(filter.placements().size(), 1U);
      EXPECT_LT((filter.placements()[0] - expected).norm(), 1e-12);
    }
  }
}

TEST(FirstLandmarkEstimator, forgets_at_a_reset) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  FirstPlaces filter(tour.settings);
  tour.warm(filter);
  filter.reset(tour.now, EstimatorTour::initial_covariance());
  ASSERT_TRUE(filter.update(tour.see({4}), tour.truth()).ok);
  EXPECT_EQ(filter.first(4), place_in_state(filter, 4)) << "the first of the new run, not landmark 3's";
}

TEST(FirstLandmarkEstimator, has_a_place_for_every_landmark_of_one_batch) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  FirstPlaces filter(tour.settings);
  filter.reset(tour.now, EstimatorTour::initial_covariance());
  ASSERT_TRUE(filter.update(tour.see({0, 1, 2, 3, 4}), tour.truth()).ok);
  EXPECT_EQ(filter.size(), 13);
  for (int number = 0; number < 5; ++number) {
    EXPECT_EQ(filter.first(number), place_in_state(filter, number)) << number;
  }
}

}  // namespace
}  // namespace credence::internal
