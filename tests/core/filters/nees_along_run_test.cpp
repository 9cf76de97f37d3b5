#include "core/filters/nees_along_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/filters/ekf_slam.h"
#include "core/linear_algebra/logarithm.h"
#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

/// A vehicle that circles among landmarks of which it sees those within six metres, each with probability
/// 0.8, and a filter that follows it.
class FollowedLoop {
 public:
  FollowedLoop(int landmarks, const Eigen::Matrix3d& P0, const Eigen::Matrix2d& R, Index anchors = 0,
               double process = 1.0)
      : R_(R), Q_(process * Eigen::Vector2d(4e-4, 1e-4).asDiagonal().toDenseMatrix()) {
    std::uniform_real_distribution<double> place(-12.0, 12.0);
    for (int i = 0; i < landmarks; ++i) places_.emplace_back(place(random_), place(random_));
    std::vector<Anchor<PlanarModel>> known;
    for (Index i = 0; i < anchors; ++i) {
      known.push_back({static_cast<int>(i), places_[static_cast<std::size_t>(i)]});
    }
    filter_.emplace(model_, Q_, R_, InflationRule{}, known);
    along_.emplace(R_);
    filter_->reset(truth_, P0);
    along_->reset(P0);
    for (Index i = 0; i < 3; ++i) truth_[i] += std::sqrt(P0(i, i)) * normal();
  }

  void step() {
    const Control u(0.5, 0.08);
    truth_ =
        model_.move(truth_, u + Control(std::sqrt(Q_(0, 0)) * normal(), std::sqrt(Q_(1, 1)) * normal())).pose;
    const Eigen::Matrix2d root = R_.llt().matrixL();
    std::vector<Observation<PlanarModel>> seen;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const RangeBearing z = measure_range_bearing(truth_, places_[i]);
      if (z[0] > 6.0 || std::uniform_real_distribution<double>()(random_) > 0.8) continue;
      seen.push_back({static_cast<int>(i), z + root * RangeBearing(normal(), normal())});
    }
    filter_->predict(u);
    Pose prior = filter_->pose() - truth_;
    prior[2] = wrap_angle(prior[2]);
    ASSERT_TRUE(filter_->update(seen).ok);
    error_ = filter_->state();
    error_.head<3>() -= truth_;
    error_[2] = wrap_angle(error_[2]);
    for (std::size_t i = 0; i < filter_->landmarks().size(); ++i) {
      error_.segment<2>(3 + 2 * static_cast<Index>(i)) -=
          places_[static_cast<std::size_t>(filter_->landmarks()[i])];
    }
    along_->step(*filter_, prior, error_,
                 filter_->rows().empty() ? 0.0 : filter_->innovation_log_determinant());
  }

  bool factor() { return along_->factor(filter_->pose_covariance().diagonal(), 1e-12); }
  const NeesAlongRun<PlanarModel>& along() const { return *along_; }
  const EkfSlam<PlanarModel>& filter() const { return *filter_; }
  const Vector& error() const { return error_; }

  /// All three numbers against a factor of P.
  void expect_same(double tolerance) {
    ASSERT_TRUE(factor());
    const Matrix& P = filter_->covariance();
    const Index n = P.rows(), map = n - 3;
    const Eigen::LLT<Matrix> root(P);
    const double nees = root.matrixL().solve(error_).squaredNorm();
    EXPECT_NEAR(along_->nees(), nees, tolerance * (static_cast<double>(n) + nees));
    EXPECT_NEAR(along_->log_determinant(), log_determinant_of_factor(root.matrixLLT()),
                tolerance * static_cast<double>(100 * n));
    if (map == 0) return;
    const Eigen::LLT<Matrix> root_of_map(Matrix(P.bottomRightCorner(map, map)));
    const double map_nees = root_of_map.matrixL().solve(error_.tail(map)).squaredNorm();
    EXPECT_NEAR(along_->map_nees(), map_nees, tolerance * (static_cast<double>(n) + map_nees));
  }

 private:
  double normal() { return std::normal_distribution<double>()(random_); }

  std::mt19937_64 random_{7};
  Eigen::Matrix2d R_, Q_;
  PlanarModel model_{.vehicle = {}, .dt_s = 1.0};
  std::vector<Point> places_;
  Pose truth_ = Pose::Zero();
  std::optional<EkfSlam<PlanarModel>> filter_;
  std::optional<NeesAlongRun<PlanarModel>> along_;
  Vector error_;
};

const Eigen::Matrix3d kStart = Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
const Eigen::Matrix2d kNoise = Eigen::Vector2d(0.01, 4e-4).asDiagonal();

TEST(NeesAlongRun, is_that_of_a_factor_of_P_at_every_step) {
  FollowedLoop loop(40, kStart, kNoise);
  for (int k = 0; k < 300 && !HasFailure(); ++k) {
    SCOPED_TRACE(k);
    loop.step();
    loop.expect_same(1e-11);
  }
  EXPECT_GT(loop.error().size(), 40);  // new landmarks came on the way
}

TEST(NeesAlongRun, of_measurements_whose_errors_are_correlated) {
  Eigen::Matrix2d R;
  R << 0.01, 0.0015, 0.0015, 4e-4;
  FollowedLoop loop(20, kStart, R);
  for (int k = 0; k < 100 && !HasFailure(); ++k) {
    loop.step();
    loop.expect_same(1e-11);
  }
}

TEST(NeesAlongRun, beside_anchors_which_are_no_states) {
  FollowedLoop loop(20, kStart, kNoise, 4);
  for (int k = 0; k < 100 && !HasFailure(); ++k) {
    loop.step();
    loop.expect_same(1e-11);
  }
}

TEST(NeesAlongRun, has_a_value_once_an_exact_start_is_forgotten) {
  FollowedLoop loop(20, Eigen::Matrix3d::Zero(), kNoise);
  loop.step();
  // Two noises have moved three states.
  EXPECT_FALSE(loop.factor());
  for (int k = 1; k < 60; ++k) loop.step();
  loop.expect_same(1e-10);
}

TEST(NeesAlongRun, has_no_value_where_the_pose_is_certain) {
  FollowedLoop loop(10, Eigen::Matrix3d::Zero(), kNoise, 0, 0.0);
  for (int k = 0; k < 20; ++k) {
    loop.step();
    EXPECT_FALSE(loop.factor());
  }
}

TEST(NeesAlongRun, depends_on_the_error_as_a_factor_of_P_does) {
  // An error that is not the filter's own: the map's is what P_ff⁻¹ e_f was made of, the pose's is free.
  FollowedLoop loop(20, kStart, kNoise);
  for (int k = 0; k < 30; ++k) loop.step();
  ASSERT_TRUE(loop.factor());
  const double before = loop.along().nees();
  const Eigen::LLT<Matrix> root(loop.filter().covariance());
  EXPECT_NEAR(before, root.matrixL().solve(loop.error()).squaredNorm(), 1e-9);
  Vector other = loop.error();
  other.tail(other.size() - 3) *= 1.01;
  EXPECT_GT(std::abs(root.matrixL().solve(other).squaredNorm() - before), 1e-3);
}

TEST(NeesAlongRun, of_the_monobot) {
  using Scalar = MonobotModel::Scalar;
  EkfSlam<MonobotModel> filter({}, Scalar(0.1), Scalar(0.1));
  NeesAlongRun<MonobotModel> along(Scalar(0.1));
  filter.reset(Scalar(0.0), Scalar(1.0));
  along.reset(Scalar(1.0));
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double truth = normal(random);
  const std::vector<double> places = {1.0, 1.3, 0.7};
  for (int k = 0; k < 50; ++k) {
    truth += std::sqrt(0.1) * normal(random);
    std::vector<Observation<MonobotModel>> seen;
    for (int i = 0; i < 3; ++i) {
      if ((k + i) % 2 == 0) continue;
      seen.push_back(
          {i, Scalar(places[static_cast<std::size_t>(i)] - truth + std::sqrt(0.1) * normal(random))});
    }
    filter.predict(Scalar(0.0));
    const Scalar prior = filter.pose() - Scalar(truth);
    ASSERT_TRUE(filter.update(seen).ok);
    Vector error = filter.state();
    error[0] -= truth;
    for (std::size_t i = 0; i < filter.landmarks().size(); ++i) {
      error[static_cast<Index>(i) + 1] -= places[static_cast<std::size_t>(filter.landmarks()[i])];
    }
    along.step(filter, prior, error, filter.rows().empty() ? 0.0 : filter.innovation_log_determinant());
    ASSERT_TRUE(along.factor(filter.pose_covariance(), 1e-12));
    const Eigen::LLT<Matrix> root(filter.covariance());
    EXPECT_NEAR(along.nees(), root.matrixL().solve(error).squaredNorm(), 1e-10) << k;
  }
}

TEST(NeesAlongRun, refuses_a_singular_R) {
  EXPECT_THROW(NeesAlongRun<PlanarModel>(Eigen::Vector2d(1.0, 0.0).asDiagonal()), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
