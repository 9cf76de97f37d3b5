#include "analysis/stability/observability_stack.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/filters/estimators/jacobian_rows.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar_slam/odometry_simulation.h"

namespace credence::internal {
namespace {

struct Ranks {
  Index stack, staircase, states;
};

/// The rank along a short run, by the stack and by the staircase over whole matrices (ranks.h).
Ranks ranks_of(const char* estimator) {
  const Scenario s = load_scenario_text(
      "[world]\nmodel = \"planar_slam\"\nlandmarks = 6\nring_offset = 1.0\npath_radius = 2.5\ndt = 1.0\n"
      "[study]\nsteps = 60\n",
      "t.toml");
  const OdometryWorld world = make_odometry_world(s);
  const auto filter = scenario_estimator(s, world, estimator);
  OdometrySimulation simulation(world, NoiseSource(1, 2));
  constexpr Index n = 15;
  ObservabilityStack stack(n);
  JacobianRows rows(n);
  std::vector<Matrix> F, H;
  Index known = 3;
  filter->reset(simulation.start(0), world.noise.initial_covariance());
  for (std::size_t k = 1; k <= 60; ++k) {
    filter->predict(simulation.read(k), world.truth(k));
    filter->update(simulation.observe(k), world.truth(k));
    rows.add(*filter, [&](const Vector& row) { stack.add(row); });
    Matrix F_k = Matrix::Identity(n, n);
    F_k.topLeftCorner<3, 3>() = filter->motion_jacobian();
    const Index m = filter->measurement_jacobian().rows();
    const Index placed = 2 * std::ssize(filter->placements());
    Matrix H_k = Matrix::Zero(m + placed, n);
    for (Index j = 0; m > 0 && j < std::ssize(filter->seen()); ++j) {
      H_k.col(filter->seen()[static_cast<std::size_t>(j)]).head(m) = filter->measurement_jacobian().col(j);
    }
    known += placed;
    for (Index i = 0; 2 * i < placed; ++i) {
      H_k.block<2, 3>(m + 2 * i, 0) = -filter->placements()[static_cast<std::size_t>(i)];
      H_k.block<2, 2>(m + 2 * i, known - placed + 2 * i).setIdentity();
    }
    F.push_back(F_k);
    H.push_back(H_k);
  }
  // local_observability takes H_k before F_k; the first measurement is after the first motion.
  H.insert(H.begin(), Matrix(0, n));
  return {stack.rank().rank, local_observability(F, H).decision.rank, rows.states()};
}

TEST(ObservabilityStack, IsTheStaircase) {
  for (const char* estimator :
       {"ekf", "ideal", "fej", "oc", "invariant", "iterated", "ukf", "smoother-fej"}) {
    const Ranks ranks = ranks_of(estimator);
    ASSERT_EQ(ranks.states, 15) << estimator;
    EXPECT_EQ(ranks.stack, ranks.staircase) << estimator;
  }
}

// The plane can be shifted and turned without anybody noticing; the filters that linearise at their newest
// estimates believe to see the turn ([Huang 2010]).
TEST(ObservabilityStack, ThreeDirectionsAreUnobservableOrTwo) {
  for (const char* estimator : {"ideal", "fej", "oc", "invariant", "invariant-left", "smoother-fej"})
    EXPECT_EQ(ranks_of(estimator).stack, 12) << estimator;
  for (const char* estimator : {"ekf", "iterated", "ukf", "schmidt", "intersection", "smoother"})
    EXPECT_EQ(ranks_of(estimator).stack, 13) << estimator;
}

}  // namespace
}  // namespace credence::internal
