#include "montecarlo/worlds/tracking/tracking_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Scenario load(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"tracking\"\n", "t.toml", overrides);
}

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    load(overrides);
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

StudyStatistics run(const Experiment& experiment, std::int64_t runs, int threads) {
  const StudyTask task{.id = {}, .experiment = &experiment, .runs = runs};
  return run_studies({&task, 1}, {.threads = threads}).front().statistics;
}

// [Bar-Shalom 2001], eqs (6.2.2-4) and (6.2.2-12), with T = 0.5 and q = 0.2.
TEST(TrackingWorld, HasTheModelOfTheBook) {
  const LinearProblem p =
      linear_problem(load({"world.dimensions=3", "world.dt=0.5", "noise.acceleration_density=0.2",
                           "noise.position_std=2", "initial.velocity_std=3", "filter.process_scale=2"}))
          .value();
  ASSERT_EQ(p.truth.state_dim(), 6);
  EXPECT_EQ(p.truth.F(1, 4), 0.5);
  EXPECT_EQ(p.truth.F(1, 3), 0.0);
  EXPECT_DOUBLE_EQ(p.truth.Q(2, 2), 0.2 * 0.125 / 3.0);
  EXPECT_DOUBLE_EQ(p.truth.Q(2, 5), 0.2 * 0.125);
  EXPECT_DOUBLE_EQ(p.truth.Q(5, 5), 0.1);
  EXPECT_EQ(p.assumed.Q, Matrix(2.0 * p.truth.Q));
  EXPECT_EQ(p.truth.R, Matrix(4.0 * Matrix::Identity(3, 3)));
  EXPECT_EQ(p.truth.P0(0, 0), 100.0);
  EXPECT_EQ(p.truth.P0(5, 5), 9.0);
  EXPECT_EQ(p.scene.layout.states[4], "velocity.y");
  ASSERT_EQ(p.scene.layout.blocks.size(), 2U);
  EXPECT_EQ(p.scene.layout.blocks[0].part, Part::position);
  EXPECT_EQ(p.scene.layout.blocks[1].name, "velocity");
}

TEST(TrackingWorld, KeysBelongToTheirSensor) {
  EXPECT_EQ(refusal({"world.sensor=range_bearing", "noise.range_std=2"}), "accepted");
  EXPECT_THAT(refusal({"noise.range_std=2"}),
              HasSubstr("accepted only with world.model = \"planar\", or with world.model = \"tracking\" and "
                        "world.sensor = \"range_bearing\""));
  EXPECT_THAT(refusal({"world.sensor=range_bearing", "noise.position_std=2"}),
              HasSubstr("accepted only with world.model = \"tracking\" and world.sensor = \"position\""));
  EXPECT_THAT(refusal({"world.sensor=range_bearing", "world.dimensions=3"}),
              HasSubstr("must be 2 with world.sensor = \"range_bearing\""));
  EXPECT_THAT(refusal({"world.dimensions=4"}), HasSubstr("an integer from 1 to 3"));
  const Scenario s = load({"world.sensor=range_bearing", "initial.velocity_std=2"});
  Scenario again = load_scenario_text(canonical_toml(s), "t.toml");
  EXPECT_EQ(again, s);
}

// A filter that knows the truth: E[NEES] = 2d, E[NIS] = d, in lanes.
TEST(TrackingWorld, PositionsAreTrackedConsistently) {
  for (const int d : {1, 2, 3}) {
    const auto experiment = make_experiment(load({"world.dimensions=" + std::to_string(d)}));
    const StudyStatistics statistics = run(*experiment, 4000, 1);
    for (const std::size_t k : {0U, 20U, 99U}) {
      const double n = 2.0 * d, runs = 4000.0;
      EXPECT_NEAR(statistics.steps[k][Quantity::nees].mean, n, 5.0 * std::sqrt(2.0 * n / runs))
          << d << ' ' << k;
      EXPECT_NEAR(statistics.steps[k][Quantity::nis].mean, d, 5.0 * std::sqrt(2.0 * d / runs))
          << d << ' ' << k;
    }
  }
}

// Far away and well measured the extended filter is nearly linear; near and badly measured it is not, and its
// error is far larger than it believes.
TEST(TrackingWorld, RangeAndBearingAreConsistentWhereTheyAreNearlyLinear) {
  const std::vector<std::string> mild = {"world.sensor=range_bearing", "world.target_range=1000",
                                         "initial.position_std=1",     "noise.range_std=1",
                                         "noise.bearing_std_deg=0.05", "study.steps=50"};
  const auto experiment = make_experiment(load(mild));
  const StudyStatistics statistics = run(*experiment, 2000, 1);
  EXPECT_TRUE(statistics.failures.empty());
  for (const std::size_t k : {0U, 10U, 49U}) {
    EXPECT_NEAR(statistics.steps[k][Quantity::nees].mean, 4.0, 5.0 * std::sqrt(8.0 / 2000.0)) << k;
    EXPECT_NEAR(statistics.steps[k][Quantity::nis].mean, 2.0, 5.0 * std::sqrt(4.0 / 2000.0)) << k;
  }
  std::vector<std::string> hard = mild;
  hard.insert(hard.end(), {"noise.bearing_std_deg=15", "initial.position_std=300"});
  const StudyStatistics far_off = run(*make_experiment(load(hard)), 2000, 1);
  const Moments& nees = far_off.steps[9][Quantity::nees];
  EXPECT_GT(nees.mean, 4.0 + 5.0 * std::sqrt(nees.variance() / 2000.0));
}

// The innovation's Jacobian against differences of the measurement itself.
TEST(TrackingWorld, ARunOfRangeAndBearingIsThatOfTheTextbook) {
  const Scenario s = load({"world.sensor=range_bearing", "noise.detection_probability=0.7"});
  const RunTrace trace = make_experiment(s)->trace(2);
  const LinearModel model = target_model(s);
  Vector x = target_start(s);
  Matrix P = model.P0;
  const auto h = [](const Vector& state) {
    return Vector((Vector(2) << std::hypot(state[0], state[1]), std::atan2(state[1], state[0])).finished());
  };
  const double bearing = s.noise.bearing_std_deg * kRadiansPerDegree;
  const Matrix R =
      (Matrix(2, 2) << s.noise.range_std * s.noise.range_std, 0, 0, bearing * bearing).finished();
  int missed = 0;
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const TraceStep& step = trace.steps[k];
    x = model.F * x;
    P = model.F * P * model.F.transpose() + model.Q;
    if (step.nis_dof == 0) {
      ++missed;
      EXPECT_EQ(step.innovation().size(), 0);
    } else {
      Matrix H(2, 4);
      for (Index j = 0; j < 4; ++j) {
        const double width = 1e-5;
        const Vector change = width * Vector::Unit(4, j);
        H.col(j) = (h(x + change) - h(x - change)) / (2.0 * width);
      }
      const Matrix S = H * P * H.transpose() + R;
      const Matrix K = P * H.transpose() * S.inverse();
      EXPECT_LT((S - step.S()).norm(), 1e-6 * S.norm()) << k;
      x += K * step.innovation();
      P = (Matrix::Identity(4, 4) - K * H) * P;
    }
    EXPECT_LT((x - step.estimate).norm(), 1e-5 * x.norm()) << k;
    EXPECT_LT((P - step.P).norm(), 1e-5 * P.norm()) << k;
    EXPECT_LT((step.estimate - step.truth - step.error).norm(), 1e-9 * step.truth.norm()) << k;
  }
  EXPECT_GT(missed, 10);
  EXPECT_LT(missed, 60);
}

TEST(TrackingWorld, ThreadsAndChunksGiveTheSameBits) {
  for (const auto& variant : std::vector<std::vector<std::string>>{
           {},
           {"noise.detection_probability=0.5"},
           {"world.sensor=range_bearing"},
           {"world.sensor=range_bearing", "noise.detection_probability=0.5"}}) {
    const auto experiment = make_experiment(load(variant));
    EXPECT_EQ(to_bytes(run(*experiment, 200, 1)), to_bytes(run(*experiment, 200, 2)));
    const StudyStatistics one = experiment->run_chunk(7, 1);
    const RunTrace trace = experiment->trace(7);
    for (std::size_t k = 1; k < trace.steps.size(); ++k) {
      EXPECT_NEAR(one.steps[k - 1][Quantity::nees].mean, trace.steps[k].nees,
                  1e-12 * (10.0 + trace.steps[k].nees));
    }
  }
}

// Noise carries a measured bearing beyond half a turn; what is recorded is an angle in (−π, π].
TEST(TrackingWorld, AMeasuredBearingIsWrapped) {
  const RunTrace trace =
      make_experiment(load({"world.sensor=range_bearing", "noise.bearing_std_deg=80"}))->trace(0);
  double largest = 0.0;
  for (const TraceStep& step : trace.steps) {
    if (step.z.size() > 0) largest = std::max(largest, std::abs(step.z[1]));
  }
  EXPECT_GT(largest, 3.0);
  EXPECT_LE(largest, std::numbers::pi);
}

}  // namespace
}  // namespace credence::internal
