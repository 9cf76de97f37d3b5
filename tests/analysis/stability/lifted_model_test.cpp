#include "analysis/stability/lifted_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "analysis/stability/boundedness.h"
#include "analysis/stability/exact_moments.h"
#include "analysis/stability/riccati.h"
#include "core/filters/linear_filter.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/linear/linear_world.h"

namespace credence::internal {
namespace {

/// Turns that are measured along one axis in one step and along the other in the next, or not at all.
std::vector<LinearModel> period_of_three() {
  std::vector<LinearModel> period(3);
  for (std::size_t k = 0; k < period.size(); ++k) {
    const double t = 0.3 + 0.2 * static_cast<double>(k);
    LinearModel& m = period[k];
    m.F = (Matrix(2, 2) << std::cos(t), -std::sin(t), std::sin(t), std::cos(t)).finished();
    m.F *= 1.05;
    m.G = Matrix::Identity(2, 2);
    m.Q = (Matrix(2, 2) << 0.2, 0.1, 0.1, 0.3).finished() * (1.0 + static_cast<double>(k));
    m.H = (Matrix(1, 2) << (k == 0 ? 1.0 : 0.0), (k == 1 ? 1.0 : 0.0)).finished();
    m.R = Matrix::Constant(1, 1, 1.0 + static_cast<double>(k));
    m.P0 = Matrix::Identity(2, 2) * 4.0;
    m.layout = {.vehicle = 2, .landmark = 0, .landmarks = 0};
  }
  return period;
}

RiccatiProblem riccati_of(const LinearModel& m) { return {m.F, m.H, m.G * m.Q * m.G.transpose(), m.R}; }

// The filter's own P at the ends of periods, step by step, and the limit.
TEST(LiftedModel, HasThePOfTheFilterAtTheEndOfEachPeriod) {
  const std::vector<LinearModel> period = period_of_three();
  const RiccatiProblem problem = riccati_of(lifted_model(period));
  const auto steps = linear_filter_steps(std::span(period), {}, 600);
  Matrix P = period.front().P0;
  for (std::size_t k = 2; k < 60; k += 3) {
    P = riccati_step(problem, P);
    EXPECT_LT((P - steps[k].P).norm(), 1e-12 * P.norm()) << k;
  }
  const RiccatiSolution limit = solve_riccati(problem, period.front().P0);
  EXPECT_EQ(limit.kind, RiccatiKind::stabilising);
  EXPECT_LT((limit.P - steps.back().P).norm(), 1e-12 * limit.P.norm());
}

// A state that drifts and is never measured: Theorem 2 says unbounded, and so it grows.
TEST(LiftedModel, KnowsWhatAPeriodNeverSees) {
  std::vector<LinearModel> period = period_of_three();
  for (LinearModel& m : period) {
    m.F = Matrix::Identity(2, 2);
    m.H = (Matrix(1, 2) << 1.0, 0.0).finished();
  }
  const RiccatiProblem unseen = riccati_of(lifted_model(period));
  EXPECT_EQ(exact_boundedness(unseen.F, unseen.H, unseen.Qt).reason, BoundednessReason::unpaired);
  EXPECT_EQ(solve_riccati(unseen, period.front().P0).kind, RiccatiKind::unbounded);
  period[1].H = (Matrix(1, 2) << 0.0, 1.0).finished();
  const RiccatiProblem seen = riccati_of(lifted_model(period));
  EXPECT_TRUE(exact_boundedness(seen.F, seen.H, seen.Qt).bounded());
}

TEST(LiftedModel, APeriodOfOneIsTheModel) {
  const std::vector<LinearModel> period = period_of_three();
  const LinearModel same = lifted_model({period.data(), 1});
  EXPECT_EQ(same.F, period.front().F);
  EXPECT_EQ(same.R, period.front().R);
}

// E[NEES] and E[NIS] of a filter that believes in too little noise, against runs.
TEST(ExactMoments, ArePeriodicWhereTheMatricesAre) {
  constexpr std::int64_t kRuns = 20'000;
  LinearProblem problem;
  const std::vector<LinearModel> period = period_of_three();
  std::vector<LinearModel> assumed = period;
  assumed[0].Q *= 0.3;
  assumed[2].F(0, 0) += 0.05;
  problem.truth = period[0];
  problem.assumed = assumed[0];
  problem.truth_later = {period[1], period[2]};
  problem.assumed_later = {assumed[1], assumed[2]};
  problem.scene = {.layout = linear_layout({"a", "b"}, assumed[0].R, true),
                   .start = Vector::Zero(2),
                   .random_start = true};
  const LinearExperiment experiment(problem, 20, NoiseSource(1, 0));
  const auto exact = exact_moments(std::span(period), assumed, experiment.filter_steps());
  const StudyTask task{.id = {}, .experiment = &experiment, .runs = kRuns};
  const StudyStatistics s = run_studies({&task, 1}, {.threads = 1}).front().statistics;
  for (const std::size_t k : {0U, 1U, 2U, 3U, 10U, 19U}) {
    const Moments &nees = s.steps[k][Quantity::nees], &nis = s.steps[k][Quantity::nis];
    const auto error = [&](const Moments& m) { return 5.0 * std::sqrt(m.variance() / kRuns); };
    EXPECT_NEAR(nees.mean, exact[k].nees, error(nees)) << k;
    EXPECT_NEAR(nis.mean, exact[k].nis, error(nis)) << k;
  }
  const auto unchanged =
      exact_moments(std::span(period).first(1), std::span(assumed).first(1), experiment.filter_steps());
  const Moments& nees = s.steps[10][Quantity::nees];
  EXPECT_GT(std::abs(nees.mean - unchanged[10].nees), 5.0 * std::sqrt(nees.variance() / kRuns)) << "no power";
}

}  // namespace
}  // namespace credence::internal
