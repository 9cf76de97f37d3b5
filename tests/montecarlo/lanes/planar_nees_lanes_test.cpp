#include "montecarlo/lanes/planar_nees_lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/lanes/planar_lanes.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {
namespace {

/// Lanes of one world in which all landmarks are seen, judged with a factor of P at chosen steps.
class JudgedLanes {
 public:
  explicit JudgedLanes(Index landmarks, bool inflate_map = false, Index anchors = 0)
      : scenario_(default_scenario("planar")) {
    scenario_.world.landmarks = landmarks;
    scenario_.world.anchors = anchors;
    if (anchors > 0) scenario_.world.observability = Observability::full;
    scenario_.study.steps = 40;
    world_ = make_planar_world(scenario_);
    const PlanarNoise noise = PlanarNoise::of(scenario_);
    lanes_.emplace(world_, Eigen::Matrix2d(noise.control_std.cwiseAbs2().asDiagonal()),
                   RangeBearing(noise.measurement_std.cwiseAbs2()), inflate_map);
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      simulations_.emplace_back(world_, noise, noise_source(scenario_));
      lanes_->reset(lane, simulations_.back().start(lane), noise.initial_covariance());
    }
  }

  void step(std::size_t k, bool factor) {
    std::array<PlanarLanes::Observations, PlanarLanes::kLanes> seen;
    std::array<Pose, PlanarLanes::kLanes> truth;
    for (std::size_t lane = 0; lane < seen.size(); ++lane) {
      simulations_[lane].move(k);
      seen[lane] = simulations_[lane].observe(k);
      truth[lane] = simulations_[lane].pose();
    }
    lanes_->predict(world_.controls[k - 1]);
    lanes_->update(seen);
    lanes_->judge(truth, false, factor ? PlanarLanes::Factor::check : PlanarLanes::Factor::if_needed);
  }

  /// eᵀ P⁻¹ e of a lane by a factor of its P.
  double by_factor(int lane) const {
    const auto& simulation = simulations_[static_cast<std::size_t>(lane)];
    Vector error = lanes_->state(lane);
    error.head<3>() -= simulation.pose();
    error[2] = wrap_angle(error[2]);
    const std::vector<int> known = lanes_->landmarks(lane);
    for (std::size_t i = 0; i < known.size(); ++i) {
      error.segment<2>(3 + 2 * static_cast<Index>(i)) -= world_.landmarks[static_cast<std::size_t>(known[i])];
    }
    return lanes_->covariance(lane).llt().matrixL().solve(error).squaredNorm();
  }

  const PlanarLanes& lanes() const { return *lanes_; }

 private:
  Scenario scenario_;
  PlanarWorld world_;
  std::optional<PlanarLanes> lanes_;
  std::vector<PlanarSimulation> simulations_;
};

void expect_by_factor(JudgedLanes judged, bool check) {
  for (std::size_t k = 1; k <= 40; ++k) {
    judged.step(k, check);
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      const double expected = judged.by_factor(lane);
      EXPECT_NEAR(judged.lanes().step(lane).nees, expected, 1e-9 * (1.0 + expected)) << k << ' ' << lane;
      EXPECT_TRUE(judged.lanes().follows(lane)) << k << ' ' << lane;
    }
  }
}

TEST(PlanarNeesLanes, are_those_of_a_factor_of_P_with_a_check_and_without) {
  expect_by_factor(JudgedLanes(12), false);
  expect_by_factor(JudgedLanes(12), true);
}

TEST(PlanarNeesLanes, of_an_inflated_map_too) {
  expect_by_factor(JudgedLanes(12, true), false);
  expect_by_factor(JudgedLanes(12, true), true);
}

TEST(PlanarNeesLanes, beside_anchors) { expect_by_factor(JudgedLanes(5, false, 2), true); }

TEST(PlanarNeesLanes, a_check_changes_no_bit) {
  JudgedLanes with(8), without(8);
  for (std::size_t k = 1; k <= 40; ++k) {
    with.step(k, true);
    without.step(k, false);
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      ASSERT_EQ(with.lanes().step(lane).nees, without.lanes().step(lane).nees);
      ASSERT_EQ(with.lanes().step(lane).vehicle_nees, without.lanes().step(lane).vehicle_nees);
    }
  }
}

TEST(PlanarNeesLanes, a_lane_has_no_value_once_it_is_not_trusted_until_its_next_run) {
  PlanarNeesLanes lanes(3, 1, best_instruction_set());
  LaneNumbers P(16), error(4), x(4);
  for (int lane = 0; lane < kPlanarLanes; ++lane) {
    lanes.reset(lane, 0.25 * Eigen::Matrix3d::Identity());
    for (std::size_t i = 0; i < 3; ++i) P[5 * i][lane] = 0.25;
    error[0][lane] = 1.0;
  }
  PlanarLanesData filter{};
  filter.states = 3;
  filter.padded = 4;
  filter.P = data(P);
  lanes.judge(filter, error);
  EXPECT_TRUE(lanes.all_have_values(kAllLanes));
  EXPECT_NEAR(lanes.nees(4), 4.0, 1e-14);
  EXPECT_EQ(lanes.map_nees(4), 0.0);
  EXPECT_NEAR(lanes.log_determinant(4), 3.0 * std::log(0.25), 1e-14);
  EXPECT_NEAR(lanes.vehicle_whitened(4)[0], 2.0, 1e-14);
  lanes.distrust(4);
  EXPECT_FALSE(lanes.has_value(4));
  EXPECT_TRUE(lanes.all_have_values(without(kAllLanes, 4)));
  lanes.judge(filter, error);
  EXPECT_FALSE(lanes.has_value(4));
  lanes.reset(4, 0.25 * Eigen::Matrix3d::Identity());
  lanes.judge(filter, error);
  EXPECT_TRUE(lanes.has_value(4));
}

TEST(PlanarNeesLanes, a_pose_that_is_certain_has_no_value) {
  PlanarNeesLanes lanes(3, 1, best_instruction_set());
  LaneNumbers P(16), error(4);
  for (int lane = 0; lane < kPlanarLanes; ++lane) {
    lanes.reset(lane, (lane == 2 ? 0.0 : 1.0) * Eigen::Matrix3d::Identity());
    for (std::size_t i = 0; i < 3; ++i) P[5 * i][lane] = 1.0;
  }
  PlanarLanesData filter{};
  filter.states = 3;
  filter.padded = 4;
  filter.P = data(P);
  lanes.judge(filter, error);
  EXPECT_FALSE(lanes.has_value(2));
  EXPECT_TRUE(lanes.all_have_values(without(kAllLanes, 2)));
}

}  // namespace
}  // namespace credence::internal
