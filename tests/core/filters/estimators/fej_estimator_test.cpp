#include "core/filters/estimators/fej_estimator.h"

#include <gtest/gtest.h>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// [Huang 2008], dense, with the first estimates of every pose and landmark beside the state.
class FirstEstimates {
 public:
  void start(const Pose& pose) { pose_ = pose; }
  Matrix predicted(const EstimatorSettings& settings, const Pose& from, const Matrix& P, const Control& u) {
    const Motion motion = settings.model.move(from, u);
    Matrix F = Matrix::Identity(3, 3);
    F.topRightCorner<2, 1>() = quarter_turn(motion.pose.head<2>() - pose_.head<2>());
    const Matrix G = textbook_control_jacobian(settings.model, from, u);
    pose_ = motion.pose;
    return textbook_prediction(P, F, G * settings.Q * G.transpose());
  }
  /// The point of linearisation: the predicted pose, and the map as it was placed.
  Vector point() const {
    Vector x(3 + std::ssize(map_));
    x << pose_, Eigen::Map<const Vector>(map_.data(), std::ssize(map_));
    return x;
  }
  void place(const Point& l) { map_.insert(map_.end(), l.begin(), l.end()); }
  const Pose& pose() const { return pose_; }

 private:
  Pose pose_ = Pose::Zero();
  std::vector<double> map_;
};

TEST(FejEstimator, is_the_textbook_filter_at_the_first_estimates) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    EstimatorTour tour(sensor);
    FejEstimator filter(tour.settings);
    FirstEstimates first;
    const Pose start = tour.now + Pose(0.1, 0.2, -0.05);
    filter.reset(start, EstimatorTour::initial_covariance());
    first.start(start);
    Vector x = start;
    Matrix P = EstimatorTour::initial_covariance();
    const std::vector<int> numbers{3, 0, 1, 4};
    for (int k = 0; k < 12; ++k) {
      const Control read = tour.drive();
      P = first.predicted(tour.settings, x.head<3>(), P, read);
      x.head<3>() = tour.settings.model.move(x.head<3>(), read).pose;
      filter.predict(read, tour.truth());
      const auto observations = tour.see(std::span(numbers).first(k < 3 ? 2 : 4));
      const auto [known, fresh] = known_and_fresh(filter, observations);
      const auto offsets = offsets_of(filter, known);
      ASSERT_TRUE(filter.update(observations, tour.truth()).ok);

      if (!known.empty()) {
        textbook_correct(tour.settings, known, offsets, first.point(), x, P);
      }
      for (const auto& o : fresh) {
        first.place(textbook_start(tour.settings, o.z, first.pose().head<2>(), x, P));
      }
      ASSERT_EQ(filter.size(), x.size());
      EXPECT_LT((filter.state() - x).norm(), 1e-7) << k;
      EXPECT_LT((whole_covariance(filter) - P).norm(), 1e-9) << k;
    }
  }
}

// All H_k Φ_k together: of 3 + 2 N columns all but three can be told, wherever the estimates went.
TEST(FejEstimator, tells_all_but_three_directions) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  FejEstimator filter(tour.settings);
  filter.reset(tour.now + Pose(0.3, -0.2, 0.1), EstimatorTour::initial_covariance());
  const std::vector<int> numbers{0, 1, 2, 3, 4};
  Matrix rows(0, 13), transition = Matrix::Identity(3, 3);
  for (int k = 0; k < 15; ++k) {
    const Control read = tour.drive();
    filter.predict(read, tour.truth());
    filter.update(tour.see(numbers), tour.truth());
    transition = (filter.motion_jacobian() * transition).eval();
    const auto add = [&](const Matrix& H_r, const Matrix& H_l, Index offset) {
      rows.conservativeResize(rows.rows() + 2, 13);
      rows.bottomRows<2>().setZero();
      rows.bottomLeftCorner<2, 3>() = H_r * transition;
      rows.block<2, 2>(rows.rows() - 2, offset) = H_l;
    };
    const Matrix H = filter.measurement_jacobian();
    for (Index i = 0; i < H.rows(); i += 2) {
      add(H.block<2, 3>(i, 0), H.block<2, 2>(i, 3 + i), filter.seen()[static_cast<std::size_t>(3 + i)]);
    }
    Index offset = 3;
    for (const auto& J_r : filter.placements()) {
      add(-J_r, Eigen::Matrix2d::Identity(), offset);
      offset += 2;
    }
  }
  const Vector values = (rows.transpose() * rows).eval().selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_LT(std::abs(values[2]), 1e-11 * values[12]);
  EXPECT_GT(values[3], 1e-6 * values[12]);
}

// A second run begins as if there had been no first.
TEST(FejEstimator, forgets_its_first_estimates_at_a_reset) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing), same = tour;
  FejEstimator used(tour.settings), fresh(tour.settings);
  EstimatorTour(LandmarkSensorKind::range_bearing, VehicleKind::unicycle, 9).warm(used);
  tour.warm(used);
  same.warm(fresh);
  EXPECT_EQ(used.state(), fresh.state());
  EXPECT_EQ(whole_covariance(used), whole_covariance(fresh));
}

}  // namespace
}  // namespace credence::internal
