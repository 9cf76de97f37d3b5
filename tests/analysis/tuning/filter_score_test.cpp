#include "analysis/tuning/filter_score.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <vector>

#include "analysis/tuning/scenario_noise.h"
#include "analysis/tuning/tuning.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

constexpr const char* kTracking = R"(
[world]
model = "tracking"
[filter]
process_scale = 0.25
[study]
runs = 60
steps = 40
)";

FilterScore tracking_score(const Scenario& scenario, const std::atomic<bool>* stop = nullptr) {
  return {{{"process_scale", scenario.filter.process_scale}, {"measurement_scale", 1.0}},
          [scenario](const std::vector<double>& values) {
            Scenario scaled = scenario;
            scaled.filter.process_scale = values[0];
            scaled.filter.measurement_scale = values[1];
            return make_experiment(scaled);
          },
          scenario.study.runs,
          2,
          stop};
}

/// The black box of a linear filter against its exact score and gradient.
TEST(FilterScore, IsTheScoreOfTheLinearFilter) {
  const Scenario scenario = load_scenario_text(kTracking, "tracking");
  const auto exact = make_scenario_score(scenario, parse_free_noise("Q,R"), 1);
  const FilterScore played = tracking_score(scenario);
  const Vector phi{{0.4, -0.3}};
  const UnitScores wanted = exact->model().scores(phi, true), got = played.scores(phi, true);
  ASSERT_TRUE(got.ok);
  EXPECT_EQ(got.steps, wanted.steps);
  EXPECT_LT((got.value - wanted.value).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((got.nis - wanted.nis).cwiseAbs().maxCoeff(), 1e-8);
  // Differences over ±0.02 are off by the third derivative, which is of the size of the first.
  EXPECT_LT((got.gradient - wanted.gradient).cwiseAbs().maxCoeff(),
            1e-3 * wanted.gradient.cwiseAbs().maxCoeff());
}

TEST(FilterScore, TunesToTheSameNoise) {
  const Scenario scenario = load_scenario_text(kTracking, "tracking");
  const auto exact = make_scenario_score(scenario, parse_free_noise("Q,R"), 1);
  const Tuning wanted = tune(exact->model(), Vector::Zero(2)),
               got = tune(tracking_score(scenario), Vector::Zero(2));
  for (Index i = 0; i < 2; ++i) {
    const double deviation = std::sqrt(wanted.estimate.covariance(i, i));
    EXPECT_NEAR(got.phi[i], wanted.phi[i], 0.02 * deviation) << i;
    EXPECT_NEAR(std::sqrt(got.estimate.covariance(i, i)), deviation, 0.02 * deviation) << i;
  }
}

TEST(FilterScore, ABadFilterLeavesNoScore) {
  const Scenario scenario = load_scenario_text(kTracking, "tracking");
  const FilterScore played = tracking_score(scenario);
  EXPECT_FALSE(played.scores(Vector{{0.0, 800.0}}, false).ok) << "R = ∞";
}

/// One run of four steps, of which the first of two sensors is silent in the third.
class TwoSensors final : public Experiment {
 public:
  TwoSensors() : Experiment(RunLayout{}) {}
  StudyStatistics run_chunk(std::int64_t, std::int64_t) const override { return {}; }
  RunTrace describe_world() const override { return {}; }
  Outcome visit(std::int64_t, const StepVisitor& take) const override {
    const std::vector<std::vector<double>> innovations = {
        {9.0, 9.0}, {2.0, 3.0}, {4.0, 5.0}, {kNaN, 7.0}, {6.0, 8.0}};
    TraceStep step;
    step.innovations.resize(2);
    for (step.step = 0; step.step < 5; ++step.step) {
      for (std::size_t sensor = 0; sensor < 2; ++sensor) {
        const double nu = innovations[static_cast<std::size_t>(step.step)][sensor];
        step.innovations[sensor] =
            std::isnan(nu) ? Innovation{} : Innovation{Vector::Constant(1, nu), Matrix::Identity(1, 1)};
      }
      take(step);
    }
    return Outcome::ok;
  }
};

TEST(FilterScore, CorrelatesSuccessiveInnovationsOfOneSensor) {
  const FilterScore score(
      {{"factor", 1.0}}, [](const auto&) { return std::make_unique<TwoSensors>(); }, 1);
  const UnitScores scores = score.scores(Vector::Zero(1), false);
  ASSERT_TRUE(scores.ok);
  EXPECT_EQ(scores.steps, 4.0) << "a step counts once";
  EXPECT_EQ(scores.dof, 7.0);
  EXPECT_TRUE(scores.composite);
  EXPECT_EQ(scores.lag_one[0], 2.0 * 4.0 + 4.0 * 6.0 + 3.0 * 5.0 + 5.0 * 7.0 + 7.0 * 8.0);
}

TEST(FilterScore, CanBeStopped) {
  const std::atomic<bool> stop = true;
  const Scenario scenario = load_scenario_text(kTracking, "tracking");
  EXPECT_THROW(tracking_score(scenario, &stop).scores(Vector::Zero(2), false), Stopped);
}

}  // namespace
}  // namespace credence::internal
