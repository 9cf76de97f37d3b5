#include "montecarlo/worlds/tracking/range_bearing_tracking.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/manifold/angle.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "montecarlo/worlds/tracking/tracking_world.h"

namespace credence::internal {
namespace {

Scenario radar_scenario(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text("[world]\nmodel = \"tracking\"\nsensor = \"range_bearing\"\n", "t.toml",
                            overrides);
}

StudyStatistics radar_chunk(const Experiment& experiment) { return experiment.run_chunk(0, 2000); }

// Far away and well measured the extended filter is nearly linear; near and badly measured it is not, and its
// error is far larger than it believes.
TEST(RangeBearingTracking, RangeAndBearingAreConsistentWhereTheyAreNearlyLinear) {
  const std::vector<std::string> mild = {"world.target_range=1000", "initial.position_std=1",
                                         "noise.range_std=1", "noise.bearing_std_deg=0.05", "study.steps=50"};
  const auto experiment = make_experiment(radar_scenario(mild));
  const StudyStatistics statistics = radar_chunk(*experiment);
  EXPECT_TRUE(statistics.failures.empty());
  for (const std::size_t k : {0U, 10U, 49U}) {
    EXPECT_NEAR(statistics.steps[k][Quantity::nees].mean, 4.0, 5.0 * std::sqrt(8.0 / 2000.0)) << k;
    EXPECT_NEAR(statistics.steps[k][Quantity::nis].mean, 2.0, 5.0 * std::sqrt(4.0 / 2000.0)) << k;
  }
  std::vector<std::string> hard = mild;
  hard.insert(hard.end(), {"noise.bearing_std_deg=15", "initial.position_std=300"});
  const StudyStatistics far_off = radar_chunk(*make_experiment(radar_scenario(hard)));
  const Moments& nees = far_off.steps[9][Quantity::nees];
  EXPECT_GT(nees.mean, 4.0 + 5.0 * std::sqrt(nees.variance() / 2000.0));
}

// The innovation's Jacobian against differences of the measurement itself.
TEST(RangeBearingTracking, ARunOfRangeAndBearingIsThatOfTheTextbook) {
  const Scenario s = radar_scenario({"noise.detection_probability=0.7"});
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

// Noise carries a measured bearing beyond half a turn; what is recorded is an angle in (−π, π].
TEST(RangeBearingTracking, AMeasuredBearingIsWrapped) {
  const RunTrace trace = make_experiment(radar_scenario({"noise.bearing_std_deg=80"}))->trace(0);
  double largest = 0.0;
  for (const TraceStep& step : trace.steps) {
    if (step.z.size() > 0) largest = std::max(largest, std::abs(step.z[1]));
  }
  EXPECT_GT(largest, 3.0);
  EXPECT_LE(largest, std::numbers::pi);
}

// The slots that the docstring names, and what is late is that of steps before.
TEST(RangeBearingTracking, NoiseIsThatOfTheSource) {
  const Scenario scenario = radar_scenario({"study.steps=8"});
  const NoiseSource source(5, 6);
  const RunTrace trace = RangeBearingTracking(scenario, source).trace(3);
  const RunTrace late =
      RangeBearingTracking(radar_scenario({"study.steps=8", "noise.measurement_delay=2"}), source).trace(3);
  ASSERT_EQ(trace.steps.size(), 9U);
  const double bearing_std = scenario.noise.bearing_std_deg * kRadiansPerDegree;
  for (std::size_t k = 0; k <= 8; ++k) {
    EXPECT_EQ(late.steps[k].truth, trace.steps[k].truth) << "a delay changes no truth";
    if (k == 0) continue;
    const auto step = static_cast<std::int64_t>(k);
    const Vector& x = trace.steps[k].truth;
    const double range = std::hypot(x[0], x[1]), bearing = std::atan2(x[1], x[0]);
    EXPECT_NEAR(trace.steps[k].z[0],
                range + scenario.noise.range_std * source.normal(3, step, NoisePurpose::measurement, 0),
                1e-9);
    EXPECT_NEAR(trace.steps[k].z[1],
                wrap_angle(bearing + bearing_std * source.normal(3, step, NoisePurpose::measurement, 1)),
                1e-12);
    if (k <= 2) {
      EXPECT_EQ(late.steps[k].z.size(), 0);
      EXPECT_EQ(late.steps[k].nis_dof, 0);
    } else {
      EXPECT_EQ(late.steps[k].z, trace.steps[k - 2].z);
    }
  }
  const LinearModel motion = target_model(scenario);
  // w = x − F x⁻ has the Q of the model: its whitened square is that of the normals drawn.
  const Vector w = trace.steps[5].truth - motion.F * trace.steps[4].truth;
  double squares = 0.0;
  for (std::int64_t slot = 0; slot < 4; ++slot) {
    const double n = source.normal(3, 5, NoisePurpose::process, slot);
    squares += n * n;
  }
  EXPECT_NEAR(w.dot(motion.Q.inverse() * w), squares, 1e-6 * squares);
}

// After one step: (F P0 Fᵀ + Q)⁻¹ plus the mean over truths of Hᵀ R⁻¹ H, whose range and bearing parts are
// along and across the line of sight, 1/σ² and 1/(rσ)².
TEST(RangeBearingBound, OfOneStepIsTheMeanInformationByHand) {
  const Scenario scenario = radar_scenario({"study.steps=1", "filter.measurement_scale=4"});
  const LinearModel motion = target_model(scenario);
  const PosteriorBound bound = range_bearing_bound(scenario);
  const double range_std = scenario.noise.range_std,
               bearing_std = scenario.noise.bearing_std_deg * kRadiansPerDegree;
  Matrix J = Matrix::Zero(4, 4);
  const auto studied = make_experiment(scenario);
  for (std::int64_t run = 0; run < kBoundRuns; ++run) {
    const Vector x = studied->trace(run).steps[1].truth;
    const Eigen::Vector2d along = x.head<2>().normalized(), across(-along[1], along[0]);
    const double r = x.head<2>().norm();
    J.topLeftCorner<2, 2>() += (along * along.transpose() / (range_std * range_std) +
                                across * across.transpose() / (r * r * bearing_std * bearing_std)) /
                               static_cast<double>(kBoundRuns);
  }
  const Matrix prior = motion.F * motion.P0 * motion.F.transpose() + motion.Q;
  const Matrix P = Matrix(prior.inverse() + J).inverse();
  EXPECT_NEAR(bound.find("position")->bound[0], P(0, 0) + P(1, 1), 1e-9 * P(0, 0));
  EXPECT_NEAR(bound.find("velocity")->bound[0], P(2, 2) + P(3, 3), 1e-9 * P(2, 2));
}

}  // namespace
}  // namespace credence::internal
