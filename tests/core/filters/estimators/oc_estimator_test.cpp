#include "core/filters/estimators/oc_estimator.h"

#include <gtest/gtest.h>

#include "core/filters/estimators/ekf_estimator.h"
#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// The turn that must stay untold, and the points at which a step linearises, as the header defines them.
class OcPoints {
 public:
  explicit OcPoints(const Point& start) : turn_(start) {}

  /// The p* of least ‖p* − p̂‖² + Σ ‖l̂₀ − n + p* − l̂‖² by its normal equations.
  Point before(const Point& estimate, const Vector& x, std::span<const Index> offsets) const {
    const Index m = 2 + 2 * std::ssize(offsets);
    Matrix A(m, 2);
    Vector b(m);
    A.topRows<2>().setIdentity();
    b.head<2>() = estimate;
    for (Index i = 2; i < m; i += 2) {
      const Index l = offsets[static_cast<std::size_t>(i - 2) / 2];
      A.middleRows<2>(i).setIdentity();
      b.segment<2>(i) = x.segment<2>(l) - first_.segment<2>(l - 3) + turn_;
    }
    return (A.transpose() * A).llt().solve(A.transpose() * b);
  }
  void move(const Point& from, const Point& to) { turn_ += to - from; }
  Vector map(const Point& position) const {
    Vector map = first_;
    for (Index i = 0; i < map.size(); i += 2) map.segment<2>(i) += position - turn_;
    return map;
  }
  void place(const Point& l) {
    first_.conservativeResize(first_.size() + 2);
    first_.tail<2>() = l;
  }
  const Point& turn() const { return turn_; }

 private:
  Point turn_;
  Vector first_;
};

TEST(OcEstimator, linearises_at_the_nearest_points_that_keep_the_turn) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  OcEstimator filter(tour.settings);
  const Pose start = tour.now + Pose(0.1, 0.2, -0.05);
  filter.reset(start, EstimatorTour::initial_covariance());
  OcPoints points(start.head<2>());
  Vector x = start;
  Matrix P = EstimatorTour::initial_covariance();
  const std::vector<int> numbers{3, 0, 1, 4};
  double largest_shift = 0.0;
  for (int k = 0; k < 12; ++k) {
    const Control read = tour.drive();
    filter.predict(read, tour.truth());
    const auto observations = tour.see(std::span(numbers).first(k < 3 ? 2 : 4));
    const auto [known, fresh] = known_and_fresh(filter, observations);
    const auto offsets = offsets_of(filter, known);
    ASSERT_TRUE(filter.update(observations, tour.truth()).ok);

    const Pose before = x.head<3>(), now = tour.settings.model.move(before, read).pose;
    const Point from = known.empty() ? Point(before.head<2>()) : points.before(before.head<2>(), x, offsets);
    largest_shift = std::max(largest_shift, (from - before.head<2>()).norm());
    Matrix F = Matrix::Identity(3, 3);
    F.topRightCorner<2, 1>() = quarter_turn(now.head<2>() - from);
    const Matrix G = textbook_control_jacobian(tour.settings.model, before, read);
    P = textbook_prediction(P, F, G * tour.settings.Q * G.transpose());
    points.move(from, now.head<2>());
    x.head<3>() = now;
    if (!known.empty()) {
      Vector at(x.size());
      at << now, points.map(now.head<2>());
      textbook_correct(tour.settings, known, offsets, at, x, P);
    }
    for (const auto& o : fresh) {
      points.place(textbook_start(tour.settings, o.z, points.turn(), x, P));
    }
    EXPECT_LT((filter.state() - x).norm(), 1e-7) << k;
    EXPECT_LT((whole_covariance(filter) - P).norm(), 1e-9) << k;
  }
  EXPECT_GT(largest_shift, 1e-3);
}

// Where all estimates are the truth there is nothing to shift, with motion between two batches or without.
TEST(OcEstimator, is_the_ekf_at_the_truth_without_a_motion_too) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.now = Pose(10.0, 5.0, 0.3);
  OcEstimator filter(tour.settings);
  EkfEstimator ekf(tour.settings);
  const auto exact = tour.see_exactly({0, 1, 2});
  for (SlamEstimator* f : {static_cast<SlamEstimator*>(&filter), static_cast<SlamEstimator*>(&ekf)}) {
    f->reset(tour.now, EstimatorTour::initial_covariance());
    f->update(exact, tour.truth());
    f->update(exact, tour.truth());
  }
  EXPECT_LT((filter.state() - ekf.state()).norm(), 1e-12);
  EXPECT_LT((whole_covariance(filter) - whole_covariance(ekf)).norm(), 1e-12);
}

// A second batch at one time has no motion before it whose Jacobian could be chosen again: P falls by the
// correction alone.
TEST(OcEstimator, chooses_the_motion_of_a_step_once) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  OcEstimator filter(tour.settings);
  tour.warm(filter);
  filter.predict(tour.drive(), tour.truth());
  ASSERT_TRUE(filter.update(tour.see({3, 0}), tour.truth()).ok);
  const Matrix P = whole_covariance(filter);
  const auto observations = tour.see({3, 1});
  const auto offsets = offsets_of(filter, observations);
  ASSERT_TRUE(filter.update(observations, tour.truth()).ok);
  Matrix H = Matrix::Zero(4, P.rows());
  const auto seen = filter.seen();
  for (std::size_t j = 0; j < seen.size(); ++j) {
    H.col(seen[j]) = filter.measurement_jacobian().col(static_cast<Index>(j));
  }
  const TextbookCorrection expected(P, H, filter.innovation(), textbook_noise(tour.settings, 4));
  EXPECT_LT((whole_covariance(filter) - expected.P).norm(), 1e-10);
}

TEST(OcEstimator, changes_nothing_where_a_batch_fails) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.settings.R *= -100.0;  // no covariance, so that S is not positive definite
  OcEstimator filter(tour.settings);
  filter.reset(tour.now, EstimatorTour::initial_covariance());
  filter.update(tour.see_exactly({0}), tour.truth());
  filter.predict(tour.control + Control(0.1, 0.05), tour.truth());
  tour.drive_exactly();
  const Vector x = filter.state();
  const Matrix P = whole_covariance(filter);
  ASSERT_FALSE(filter.update(tour.see_exactly({0}), tour.truth()).ok);
  EXPECT_EQ(filter.state(), x);
  EXPECT_LT((whole_covariance(filter) - P).norm(), 1e-12 * P.norm());
}

}  // namespace
}  // namespace credence::internal
