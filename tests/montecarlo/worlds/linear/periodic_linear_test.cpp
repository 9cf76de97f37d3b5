#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

// F and R of period 2; what the filter believes of Q has a period, too.
const std::string kPeriodic =
    "[world]\nmodel = \"linear\"\nperiod = 2\n"
    "F = [[1, 0.5], [0, 0.9], [1, 1], [-0.1, 1]]\nH = [[1, 0]]\nQ = [[0.2, 0.1], [0.1, 0.3]]\n"
    "R = [[1], [4]]\nP0 = [[4, 1], [1, 4]]\n";
const std::string kOwnQ = "[filter]\nQ = [[0.1, 0], [0, 0.1], [0.4, 0], [0, 0.4]]\n";

Scenario periodic(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(text, "s.toml", overrides);
}

std::string periodic_refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return scenario_refusal([&] { periodic(text, overrides); });
}

TEST(PeriodicLinearWorld, ReadsTheMatricesOfEachStep) {
  const LinearProblem p = linear_problem(periodic(kPeriodic + kOwnQ)).value();
  ASSERT_EQ(p.truth_period().size(), 2U);
  EXPECT_EQ(p.truth_later[0].F, (Matrix(2, 2) << 1, 1, -0.1, 1).finished());
  EXPECT_EQ(p.truth_later[0].R(0, 0), 4.0);
  EXPECT_EQ(p.truth_later[0].Q, p.truth.Q);
  EXPECT_EQ(p.assumed_later[0].Q, Matrix(0.4 * Matrix::Identity(2, 2)));
  EXPECT_EQ(p.assumed_later[0].F, p.truth_later[0].F);
  const Scenario s = periodic(kPeriodic + kOwnQ);
  EXPECT_EQ(periodic(canonical_toml(s)), s);
}

TEST(PeriodicLinearWorld, RefusesWhatIsNoPeriod) {
  EXPECT_THAT(periodic_refusal(kPeriodic, {"world.period=3"}), HasSubstr("or 3 of them one above the other"));
  EXPECT_THAT(periodic_refusal(kPeriodic, {"world.P0=[[4, 1], [1, 4], [4, 1], [1, 4]]"}),
              HasSubstr("that of the start alone"));
  EXPECT_THAT(periodic_refusal(kPeriodic, {"world.R=[[1], [-4]]"}), HasSubstr("positive semidefinite"));
  EXPECT_THAT(periodic_refusal(kPeriodic, {"world.period=1"}), HasSubstr("square"));
}

// A period of equal steps is no period: the same bits.
TEST(PeriodicLinearWorld, APeriodOfEqualStepsChangesNoBit) {
  const std::string once =
      "[world]\nmodel = \"linear\"\nF = [[1, 0.5], [-0.1, 0.9]]\nH = [[1, 0]]\nQ = [[0.2, 0.1], [0.1, 0.3]]\n"
      "R = [[2]]\nP0 = [[4, 1], [1, 4]]\n";
  const std::string thrice =
      "[world]\nmodel = \"linear\"\nperiod = 3\n"
      "F = [[1, 0.5], [-0.1, 0.9], [1, 0.5], [-0.1, 0.9], [1, 0.5], [-0.1, 0.9]]\nH = [[1, 0]]\n"
      "Q = [[0.2, 0.1], [0.1, 0.3]]\nR = [[2], [2], [2]]\nP0 = [[4, 1], [1, 4]]\n";
  for (const std::string probability : {"1", "0.7"}) {
    const std::string seen = "noise.detection_probability=" + probability;
    const NoiseSource source(1, 2);
    const auto make = [&](const std::string& text) {
      return make_linear_experiment(linear_problem(periodic(text, {seen})).value(), 50, source);
    };
    EXPECT_EQ(make(once)->run_chunk(3, 40), make(thrice)->run_chunk(3, 40)) << probability;
  }
}

TEST(PeriodicLinearWorld, AChunkHasTheRunsOfItsTraces) {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{}, {"noise.detection_probability=0.7"}, {"filter.F=[[1, 0.6], [0, 0.9]]"}}) {
    const auto experiment = make_experiment(periodic(kPeriodic + kOwnQ, overrides));
    const StudyStatistics one = experiment->run_chunk(5, 1);
    const RunTrace trace = experiment->trace(5);
    for (std::size_t k = 1; k < trace.steps.size(); ++k) {
      EXPECT_NEAR(one.steps[k - 1][Quantity::nees].mean, trace.steps[k].nees,
                  1e-12 * (10.0 + trace.steps[k].nees));
    }
  }
}

// A run against the textbook's filter with the matrices of each step.
TEST(PeriodicLinearWorld, ARunIsThatOfTheTextbook) {
  const Scenario s = periodic(kPeriodic + kOwnQ);
  const LinearProblem p = linear_problem(s).value();
  const auto assumed = p.assumed_period();
  const RunTrace trace = make_experiment(s)->trace(3);
  Vector x = Vector::Zero(2);
  Matrix P = p.assumed.P0;
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const LinearModel& now = assumed[(k - 1) % 2];
    const TraceStep& step = trace.steps[k];
    x = now.F * x;
    P = now.F * P * now.F.transpose() + now.Q;
    const double S = P(0, 0) + now.R(0, 0);
    const Vector K = P.col(0) / S;
    x += K * (step.z[0] - x[0]);
    P -= (K * S * K.transpose()).eval();
    EXPECT_LT((x - step.estimate).norm(), 1e-9 * (1.0 + step.truth.norm())) << k;
    EXPECT_LT((P - step.P).norm(), 1e-9 * P.norm()) << k;
  }
}

}  // namespace
}  // namespace credence::internal
