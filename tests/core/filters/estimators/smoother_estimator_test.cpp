#include "core/filters/estimators/smoother_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "tests/core/filters/estimators/estimator_tour.h"

namespace credence::internal {
namespace {

/// The window by its normal equations, its oldest pose eliminated by a Schur complement.
class DenseWindow {
 public:
  DenseWindow(const EstimatorSettings& settings, const Pose& pose, const Matrix& P)
      : settings_(settings), mean_(pose), information_(P.inverse()), poses_{pose}, seen_(1) {}

  void add(const Control& u, const EstimatorTour::Observations& observations) {
    controls_.push_back(u);
    poses_.push_back(settings_.model.move(Pose(poses_.back()), u).pose);
    seen_.push_back(observations);
    for (const auto& o : observations) {
      if (std::ranges::find(order_, o.landmark) != order_.end()) continue;
      order_.push_back(o.landmark);
      const Vector l = textbook_place(settings_, poses_.back(), o.z);
      map_.conservativeResize(map_.size() + 2);
      map_.tail(2) = l;
    }
    for (int k = 0; k < 100; ++k) {
      const Vector step = solve();
      move(step);
      if (step.norm() < 1e-9) break;
    }
    solve();
    if (std::ssize(controls_) == settings_.window) marginalise();
  }

  /// The newest pose and the map, and their covariance.
  Vector state() const {
    Vector x(3 + map_.size());
    x << poses_.back(), map_;
    return x;
  }
  const Matrix& covariance() const { return P_; }

 private:
  /// All poses, then the map.
  Index map_at() const { return 3 * std::ssize(poses_); }
  Index place_of(int landmark) const { return 2 * (std::ranges::find(order_, landmark) - order_.begin()); }

  /// Adds JᵀWJ and −JᵀWr of a residual of some unknowns.
  void add_term(const Matrix& J, const Vector& r, const std::vector<Index>& of, const Matrix& W) {
    A_(of, of) += J.transpose() * W * J;
    b_(of) -= J.transpose() * W * r;
  }

  /// R_kᵀ (p_k+1 − p_k) and the turn, less what the odometry read.
  void add_motion(std::size_t k) {
    const Motion local = settings_.model.move(Pose::Zero(), controls_[k]);
    const Vector &from = poses_[k], &to = poses_[k + 1];
    const Eigen::Matrix2d Rt = rotation(from[2]).transpose();
    const Eigen::Vector2d way = to.head<2>() - from.head<2>();
    Vector r(3);
    r << Rt * way - local.pose.head<2>(), wrap_angle(to[2] - from[2] - local.pose[2]);
    Matrix J = Matrix::Zero(3, 6);
    J.topLeftCorner(2, 2) = -Rt;
    J.block(0, 2, 2, 1) = -Rt * quarter_turn(way);
    J.block(0, 3, 2, 2) = Rt;
    J(2, 2) = -1.0;
    J(2, 5) = 1.0;
    // of rank two: what goes sideways is all but without noise
    const Matrix noise = local.G * settings_.Q * local.G.transpose() + 1e-10 * Matrix::Identity(3, 3);
    std::vector<Index> of;
    for (Index i = 0; i < 6; ++i) of.push_back(3 * static_cast<Index>(k) + i);
    add_term(J, r, of, noise.inverse());
  }

  void add_observations(std::size_t k) {
    for (const auto& o : seen_[k]) {
      const Index l = place_of(o.landmark), p = 3 * static_cast<Index>(k);
      const std::vector<Index> of = {p, p + 1, p + 2, map_at() + l, map_at() + l + 1};
      Vector at(5);
      at << poses_[k], map_.segment(l, 2);
      const std::vector<Index> place = {3};
      add_term(textbook_jacobian(settings_, at, place),
               -textbook_innovation(settings_, o.z, textbook_measurement(settings_, at, place)), of,
               settings_.R.inverse());
    }
  }

  /// Of the oldest pose and the landmarks known by then.
  void add_prior() {
    const Index known = mean_.size() - 3;
    std::vector<Index> of = {0, 1, 2};
    for (Index i = 0; i < known; ++i) of.push_back(map_at() + i);
    Vector r(mean_.size());
    r << poses_.front() - mean_.head(3), map_.head(known) - mean_.tail(known);
    r[2] = wrap_angle(r[2]);
    A_(of, of) += information_;
    b_(of) -= information_ * r;
  }

  void clear() {
    const Index size = map_at() + map_.size();
    A_.setZero(size, size);
    b_.setZero(size);
  }

  Vector solve() {
    clear();
    add_prior();
    for (std::size_t k = 0; k < controls_.size(); ++k) add_motion(k);
    for (std::size_t k = 0; k < seen_.size(); ++k) add_observations(k);
    const Matrix P = A_.inverse();
    const Index last = 3 + map_.size();
    P_ = P.bottomRightCorner(last, last);
    return P * b_;
  }

  void move(const Vector& step) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      poses_[k] += step.segment(3 * static_cast<Index>(k), 3);
      poses_[k][2] = wrap_angle(poses_[k][2]);
    }
    map_ += step.tail(map_.size());
  }

  /// What prior, observations of the oldest pose and motion to the next tell of that and of the landmarks
  /// seen.
  void marginalise() {
    const Index earlier = mean_.size() - 3;
    Index known = earlier;
    for (const auto& o : seen_.front()) known = std::max(known, place_of(o.landmark) + 2);
    clear();
    add_prior();
    add_motion(0);
    add_observations(0);
    std::vector<Index> gone = {0, 1, 2}, kept = {3, 4, 5};
    for (Index i = 0; i < known; ++i) kept.push_back(map_at() + i);
    const Matrix of_gone = A_(gone, gone), cross = A_(kept, gone);
    information_ = Matrix(A_(kept, kept)) - cross * of_gone.ldlt().solve(cross.transpose());
    const Vector rest = Vector(b_(kept)) - cross * of_gone.ldlt().solve(Vector(b_(gone)));
    mean_.resize(3 + known);
    mean_ << poses_[1], map_.head(known);
    mean_ += information_.ldlt().solve(rest);
    poses_.erase(poses_.begin());
    seen_.erase(seen_.begin());
    controls_.erase(controls_.begin());
  }

  EstimatorSettings settings_;
  Vector mean_;
  Matrix information_;
  std::vector<Vector> poses_;
  std::vector<Control> controls_;
  std::vector<EstimatorTour::Observations> seen_;
  std::vector<int> order_;
  Vector map_{0};
  Matrix A_, P_;
  Vector b_;
};

/// In standard deviations: where the plane lies and how it is turned is known least, by far.
double deviations(const SmootherEstimator& filter, const DenseWindow& dense) {
  const Vector off = filter.state() - dense.state();
  return std::sqrt(off.dot(dense.covariance().llt().solve(off)));
}

/// Seven steps of a smoother beside the least squares of the same; `check` after each, until one fails.
template <class Check>
void beside_the_window(EstimatorTour& tour, Check check) {
  SmootherEstimator filter(tour.settings);
  const Pose start = tour.now + Pose(0.01, -0.01, 0.005);
  const Eigen::Matrix3d P0 = 1e-2 * EstimatorTour::initial_covariance();
  filter.reset(start, P0);
  DenseWindow dense(tour.settings, start, P0);
  for (const auto& numbers :
       {std::vector<int>{3, 0}, {0, 3, 1}, {4, 3}, {1, 0, 4}, {2, 0}, {1, 3, 4}, {2, 4, 0}}) {
    const Control read = tour.drive();
    const auto observations = tour.see(numbers);
    filter.predict(read, tour.truth());
    const UpdateResult updated = filter.update(observations, tour.truth());
    dense.add(read, observations);
    check(updated, filter, dense);
    if (testing::Test::HasFailure()) return;
  }
}

// A filter through the window is the least squares of the window: prior, motions and observations, and what
// has left it, settled to 10⁻⁵ m.
TEST(SmootherEstimator, is_the_least_squares_of_its_window) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const Index window : {1, 2, 4}) {
      EstimatorTour tour(sensor);
      tour.settings.window = window;
      tour.settings.Q *= 1e-3;
      tour.settings.R *= 1e-3;
      beside_the_window(tour, [&](const UpdateResult& updated, const SmootherEstimator& filter,
                                  const DenseWindow& dense) {
        ASSERT_TRUE(updated.ok);
        EXPECT_LT(deviations(filter, dense), 0.03) << window;
        EXPECT_LT((whole_covariance(filter) - dense.covariance()).norm(), 3e-3 * dense.covariance().norm())
            << window;
      });
      if (HasFailure()) return;
    }
  }
}

// Of noise for which ten iterations of Gauss-Newton leave it up to 0.3 standard deviations off.
TEST(SmootherEstimator, GoesOnUntilItHasSettled) {
  for (const LandmarkSensorKind sensor :
       {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
    for (const Index window : {1, 2, 4}) {
      for (const unsigned seed : {1U, 2U, 3U, 4U}) {
        EstimatorTour tour(sensor, VehicleKind::unicycle, seed);
        tour.settings.window = window;
        tour.settings.Q *= 30.0;
        tour.settings.R *= 30.0;
        beside_the_window(tour, [&](const UpdateResult& updated, const SmootherEstimator& filter,
                                    const DenseWindow& dense) {
          ASSERT_TRUE(updated.ok && updated.converged) << window << " " << seed;
          ASSERT_LT(deviations(filter, dense), 1e-3) << window << " " << seed;
        });
        if (HasFailure()) return;
      }
    }
  }
}

// Steps without an observation are motions put together: three of them are one of the window.
TEST(SmootherEstimator, puts_motions_without_observations_together) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.settings.window = 50;
  SmootherEstimator often(tour.settings), seldom(tour.settings);
  often.reset(tour.now, EstimatorTour::initial_covariance());
  seldom.reset(tour.now, EstimatorTour::initial_covariance());
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < 3; ++i) {
      const Control read = tour.drive();
      often.predict(read, tour.truth());
      seldom.predict(read, tour.truth());
      if (i < 2) EXPECT_TRUE(seldom.update({}, tour.truth()).ok);
    }
    const auto observations = tour.see({0, 1, 3});
    often.update(observations, tour.truth());
    seldom.update(observations, tour.truth());
    EXPECT_EQ(Vector(often.state()), Vector(seldom.state()));
  }
}

// With Jacobians where a prior took them the turn of the plane stays unknown. The truth is a drive without
// noise, the estimates are not: of the heading the plain one grows certain.
TEST(SmootherEstimator, first_estimates_do_not_tell_the_heading) {
  double heading[2];
  for (const bool first : {false, true}) {
    EstimatorTour tour(LandmarkSensorKind::range_bearing, VehicleKind::unicycle, 4);
    tour.settings.window = 2;
    tour.settings.Q *= 4.0;
    tour.control = Control(0.8, 0.4);
    SmootherEstimator filter(tour.settings, first);
    filter.reset(tour.now, EstimatorTour::initial_covariance());
    for (int k = 0; k < 150; ++k) {
      filter.predict(tour.drive(), tour.truth());
      ASSERT_TRUE(filter.update(tour.see({0, 1, 2, 3, 4}), tour.truth()).ok);
    }
    heading[first] = filter.covariance()(2, 2);
  }
  const double initial = EstimatorTour::initial_covariance()(2, 2);
  // the batch could tell no more of the turn than the start does
  EXPECT_GT(heading[true], 0.5 * initial);
  EXPECT_LT(heading[false], heading[true]);
}

}  // namespace
}  // namespace credence::internal
