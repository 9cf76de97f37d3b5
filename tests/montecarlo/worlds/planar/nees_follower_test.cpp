#include "montecarlo/worlds/planar/nees_follower.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

constexpr double kStd = 0.1;

/// A filter that has driven by four landmarks, and what a factor of its P tells of an error of 0.05
/// everywhere.
struct Followed {
  explicit Followed(const InflationRule& rule = {})
      : filter({.vehicle = {}, .dt_s = 0.5}, 0.01 * Eigen::Matrix2d::Identity(),
               kStd * kStd * Eigen::Matrix2d::Identity(), rule),
        follower(filter) {
    filter.reset(Pose::Zero(), kStd * kStd * Eigen::Matrix3d::Identity());
    follower.start(kStd * kStd * Eigen::Matrix3d::Identity());
    for (int k = 0; k < 3; ++k) step();
  }

  void step() {
    filter.predict({1.0, 0.1});
    const Pose prior = follower.prior(filter.pose() - Pose::Constant(0.05));
    std::vector<Observation<PlanarModel>> z;
    for (int i = 0; i < 4; ++i) z.push_back({i, RangeBearing(5.0 + i, 0.3 * i)});
    filter.update(z);
    follower.step(prior, Vector::Constant(filter.state().size(), 0.05));
    by_factor = solver.solve(Vector::Constant(filter.state().size(), 0.05), filter.covariance());
  }

  EkfSlam<PlanarModel> filter;
  NeesFollower follower;
  NeesSolver solver;
  NeesValue by_factor;
};

TEST(NeesFollower, has_no_value_of_a_filter_that_inflates) {
  InflationRule map, constant;
  map.inflation = Inflation::map;
  constant.constant = 0.01 * Matrix::Identity(11, 11);
  EXPECT_FALSE(Followed(map).follower.has_value());
  EXPECT_FALSE(Followed(constant).follower.has_value());
  EXPECT_TRUE(Followed().follower.has_value());
}

TEST(NeesFollower, has_no_value_of_measurements_without_noise) {
  const EkfSlam<PlanarModel> filter({}, Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Zero());
  NeesFollower follower(filter);
  follower.start(Eigen::Matrix3d::Identity());
  follower.step(Pose::Zero(), Vector::Zero(3));
  EXPECT_FALSE(follower.has_value());
}

TEST(NeesFollower, a_check_that_agrees_keeps_it) {
  Followed f;
  // The error of the landmarks is free here, that of the step before: the same, as it is constant.
  f.step();
  ASSERT_TRUE(f.follower.has_value());
  f.follower.check({f.follower.nees().value * (1.0 + 1e-9), f.follower.nees().dof}, f.solver);
  EXPECT_TRUE(f.follower.has_value());
  f.step();
  EXPECT_TRUE(f.follower.has_value());
}

TEST(NeesFollower, a_check_that_does_not_ends_it_for_the_run) {
  Followed f;
  f.follower.check({f.follower.nees().value + 1e-4, f.follower.nees().dof}, f.solver);
  EXPECT_FALSE(f.follower.has_value());
  f.step();
  EXPECT_FALSE(f.follower.has_value());
  f.follower.start(Eigen::Matrix3d::Identity());
  f.filter.reset(Pose::Zero(), Eigen::Matrix3d::Identity());
  f.step();
  EXPECT_TRUE(f.follower.has_value());
}

TEST(NeesFollower, so_does_a_factor_of_fewer_states) {
  Followed f;
  f.follower.check({f.follower.nees().value, f.follower.nees().dof - 1}, f.solver);
  EXPECT_FALSE(f.follower.has_value());
}

}  // namespace
}  // namespace credence::internal
