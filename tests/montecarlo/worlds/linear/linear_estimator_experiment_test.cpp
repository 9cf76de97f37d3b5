#include "montecarlo/worlds/linear/linear_estimator_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/linear/linear_world.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

const std::string kEstimated =
    "[world]\nmodel = \"linear\"\nF = [[1, 0.5], [-0.1, 0.9]]\nH = [[1, 0]]\n"
    "Q = [[0.2, 0.1], [0.1, 0.3]]\nR = [[0.5]]\nP0 = [[4, 1], [1, 4]]\n[study]\nsteps = 60\n";

Scenario estimated_scenario(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(kEstimated, "s.toml", overrides);
}

std::string estimator_refusal(const std::string& name, const std::vector<std::string>& overrides) {
  try {
    linear_estimator_experiment(estimated_scenario(overrides), name);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LinearEstimatorExperiment, NamesWhatTheScenarioMustSayForIt) {
  EXPECT_THAT(estimator_refusal("schmidt", {}),
              HasSubstr("filter.estimator = \"schmidt\" needs filter.considered"));
  EXPECT_THAT(estimator_refusal("own-gain", {}),
              HasSubstr("filter.estimator = \"own-gain\" needs filter.gain"));
  for (const char* name : {"steady-state", "smoother"}) {
    EXPECT_EQ(estimator_refusal(name, {}), "accepted");
    for (const auto& [override, said] : std::vector<std::pair<std::string, std::string>>{
             {"noise.detection_probability=0.5",
              "needs every measurement: noise.detection_probability is 0.5"},
             {"noise.measurement_delay=1", "noise.measurement_delay"},
             {"noise.outlier_rate=0.1", "white and Gaussian; \"kalman\" takes any"},
             {"noise.process_correlation=0.5", "white and Gaussian"}}) {
      EXPECT_THAT(estimator_refusal(name, {override}),
                  HasSubstr(std::string("filter.estimator = \"") + name + "\""));
      EXPECT_THAT(estimator_refusal(name, {override}), HasSubstr(said)) << name;
      EXPECT_EQ(estimator_refusal("kalman", {override}), "accepted") << override;
    }
  }
}

/// P of every step as shown, and the gain.
std::vector<TraceStep> estimated_steps(const std::string& name,
                                       const std::vector<std::string>& overrides = {}) {
  return linear_estimator_experiment(estimated_scenario(overrides), name)->trace(0).steps;
}

// Far from its start the Kalman filter has the gain that the steady one has from its first step on; and all
// of them meet the same truth.
TEST(LinearEstimatorExperiment, TheSteadyGainIsTheLimitOfTheKalmanFilters) {
  const std::vector<TraceStep> kalman = estimated_steps("kalman"), steady = estimated_steps("steady-state");
  EXPECT_LT((steady[1].K - kalman[60].K).norm(), 1e-10);
  EXPECT_EQ(steady[1].K, steady[60].K);
  EXPECT_LT((steady[60].P - kalman[60].P).norm(), 1e-8);
  for (std::size_t k = 0; k <= 60; ++k) EXPECT_EQ(steady[k].truth, kalman[k].truth);
  // Optimal gains have the least P at every step.
  for (std::size_t k = 1; k <= 60; ++k) EXPECT_GE(steady[k].P.trace(), kalman[k].P.trace() * (1.0 - 1e-12));
}

// Of any gain P⁺ = (I − K H) P⁻ (I − K H)ᵀ + K R Kᵀ, of a filter that says of its own gain what it does.
TEST(LinearEstimatorExperiment, OfAGainOfOnesOwnPIsJosephs) {
  const std::vector<TraceStep> own = estimated_steps("own-gain", {"filter.gain=[[0.6], [0.1]]"});
  const LinearModel model = linear_world_problem(estimated_scenario()).truth;
  const Matrix K = (Matrix(2, 1) << 0.6, 0.1).finished(), T = Matrix::Identity(2, 2) - K * model.H;
  Matrix P = model.P0;
  for (std::size_t k = 1; k <= 60; ++k) {
    P = (T * (model.F * P * model.F.transpose() + model.Q) * T.transpose() + K * model.R * K.transpose())
            .eval();
    EXPECT_LT((own[k].P - P).norm(), 1e-10 * P.norm()) << k;
    EXPECT_EQ(own[k].K, K);
  }
}

// A considered state is not corrected, and its P is that of no measurement.
TEST(LinearEstimatorExperiment, AConsideredStateIsNotCorrected) {
  const std::vector<TraceStep> schmidt =
      estimated_steps("schmidt", {"filter.considered=[\"x2\"]", "world.F=[[1, 0.5], [0, 0.9]]"});
  Matrix P = (Matrix(1, 1) << 4.0).finished();
  for (std::size_t k = 1; k <= 60; ++k) {
    P = 0.81 * P + Matrix::Constant(1, 1, 0.3);
    EXPECT_EQ(schmidt[k].K(1, 0), 0.0);
    EXPECT_NEAR(schmidt[k].P(1, 1), P(0, 0), 1e-10) << k;
  }
}

// A gain under which the error grows does not settle, nor one of a model without a limit.
TEST(LinearEstimatorExperiment, AModelWithoutASteadyGainIsRefused) {
  EXPECT_NE(estimator_refusal("steady-state", {"world.F=[[1.5, 0], [0, 2]]", "world.H=[[1, 0]]"}),
            "accepted");
}

TEST(LinearEstimatorNames, AreThoseThatTheScenarioSaysEnoughFor) {
  const auto names = [](const std::vector<std::string>& overrides) {
    const Scenario scenario = estimated_scenario(overrides);
    return linear_estimator_names(&scenario);
  };
  EXPECT_EQ(names({}).size(), 3U);
  EXPECT_EQ(names({"filter.gain=[[0.6], [0.1]]"}).back(), "own-gain");
  EXPECT_EQ(names({"filter.considered=[\"x1\"]"}).back(), "schmidt");
  EXPECT_EQ(linear_estimator_names(nullptr).size(), 5U);
}

}  // namespace
}  // namespace credence::internal
