#include "montecarlo/worlds/linear/linear_experiment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "core/simd/cpu_dispatch.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

const std::string kPlayed =
    "[world]\n"
    "model = \"linear\"\n"
    "F = [[1, 0.5], [-0.1, 0.9]]\n"
    "H = [[1, 0], [1, 1], [0.5, 0]]\n"
    "Q = [[0.2, 0.1], [0.1, 0.3]]\n"
    "R = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n"
    "P0 = [[4, 1], [1, 4]]\n";

Scenario played_scenario(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(text, "s.toml", overrides);
}

const std::vector<std::vector<std::string>> kPlayedVariants = {
    {},
    {"filter.F=[[1, 0.4], [-0.1, 0.8]]", "filter.H=[[1, 0], [1, 0.9], [0.5, 0]]"},
    {"noise.detection_probability=0.6"},
    {"noise.detection_probability=0.6", "filter.F=[[1, 0.4], [-0.1, 0.8]]"},
    {"world.P0=[[1, 1], [1, 1]]", "world.Q=[[0, 0], [0, 0]]"}};

// As every world: a run ends with the step at which it failed, which has no numbers.
TEST(LinearExperiment, ARunThatFailsShowsWhere) {
  const char* text =
      "[world]\nmodel = \"linear\"\nF = [[2]]\nH = [[0]]\nQ = [[1]]\nR = [[1]]\nP0 = [[1]]\n"
      "[study]\nsteps = 1200\n";
  for (const char* detection : {"1", "0.9"}) {
    const auto experiment =
        make_experiment(played_scenario(text, {std::string("noise.detection_probability=") + detection}));
    const StudyStatistics chunk = experiment->run_chunk(0, 1);
    ASSERT_EQ(chunk.failures.size(), 1U) << detection;
    const RunTrace trace = experiment->trace(0);
    EXPECT_EQ(trace.outcome, Outcome::not_positive_definite);
    EXPECT_EQ(trace.steps.back().step, chunk.failures[0].step);
    EXPECT_EQ(trace.steps.back().outcome, Outcome::not_positive_definite);
    EXPECT_EQ(trace.steps.back().nees_dof, 0);
    EXPECT_EQ(trace.steps[trace.steps.size() - 2].outcome, Outcome::ok);
  }
}

TEST(LinearExperiment, InstructionSetsGiveTheSameBits) {
  if (best_instruction_set() == InstructionSet::scalar) GTEST_SKIP() << "one instruction set cannot differ";
  for (const auto& variant : kPlayedVariants) {
    const Scenario s = played_scenario(kPlayed, variant);
    const auto bytes = [&](InstructionSet set) {
      const NoiseSource source(s.study.seed, noise_group(s), set);
      return to_bytes(
          make_linear_experiment(linear_problem(s).value(), s.study.steps, source)->run_chunk(0, 100));
    };
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      EXPECT_EQ(bytes(set), bytes(InstructionSet::scalar));
    }
  }
}

/// The Kalman filter of the textbook that meets the truth and the measurements of a trace.
void expect_textbook(const RunTrace& trace, const LinearModel& truth, const LinearModel& assumed) {
  const Index n = assumed.state_dim();
  Vector x = trace.steps.front().estimate;
  Matrix P = assumed.P0;
  EXPECT_TRUE(x.isZero(0.0)) << "the filter starts at the mean";
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const TraceStep& step = trace.steps[k];
    x = assumed.F * x;
    P = assumed.F * P * assumed.F.transpose() + assumed.G * assumed.Q * assumed.G.transpose();
    std::vector<Index> rows;
    for (Index i = 0; i < step.z.size(); ++i) {
      if (std::isfinite(step.z[i])) rows.push_back(i);
    }
    const Matrix H = assumed.H(rows, Eigen::all), R = assumed.R(rows, rows);
    const Matrix S = H * P * H.transpose() + R;
    const Matrix K = P * H.transpose() * S.inverse();
    x += K * (Vector(step.z(rows)) - H * x);
    P = (Matrix::Identity(n, n) - K * H) * P;
    const double scale = 1e-9 * (1.0 + step.truth.norm());
    EXPECT_LT((x - step.estimate).norm(), scale) << k;
    EXPECT_LT((x - step.truth - step.error).norm(), scale) << k;
    EXPECT_LT((P - step.P).norm(), 1e-9 * P.norm()) << k;
    EXPECT_NEAR(step.nees, step.error.dot(P.inverse() * step.error), 1e-6 * (1.0 + step.nees)) << k;
    EXPECT_EQ(truth.state_dim(), n);
  }
}

TEST(LinearExperiment, ARunIsThatOfTheTextbook) {
  for (std::size_t v = 0; v < 4; ++v) {
    const Scenario s = played_scenario(kPlayed, kPlayedVariants[v]);
    const LinearProblem p = linear_problem(s).value();
    expect_textbook(make_experiment(s)->trace(3), p.truth, p.assumed);
  }
}

TEST(LinearExperiment, AChunkHasTheRunsOfItsTraces) {
  for (const auto& variant : kPlayedVariants) {
    const auto experiment = make_experiment(played_scenario(kPlayed, variant));
    const StudyStatistics one = experiment->run_chunk(5, 1);
    const RunTrace trace = experiment->trace(5);
    for (std::size_t k = 1; k < trace.steps.size(); ++k) {
      // A chunk takes the dof off before it sums.
      EXPECT_NEAR(one.steps[k - 1][Quantity::nees].mean, trace.steps[k].nees,
                  1e-12 * (10.0 + trace.steps[k].nees));
      EXPECT_EQ(one.steps[k - 1].nees_dof, trace.steps[k].nees_dof);
    }
  }
}

// Filter steps that end early, where S was not positive definite, end every run there.
TEST(LinearExperiment, StepsOfAFilterThatEndEarlyEndEveryRun) {
  const LinearProblem problem = linear_problem(played_scenario(kPlayed)).value();
  std::vector<LinearFilterStep> steps = linear_filter_steps(problem.assumed_period(), problem.rule, 10);
  steps[6].ok = false;
  steps[2].converged = false;
  steps[8].converged = false;  // beyond the end
  const LinearExperiment experiment(problem, 10, NoiseSource(1, 1), steps);
  const StudyStatistics chunk = experiment.run_chunk(4, 3);
  ASSERT_EQ(chunk.steps.size(), 10U);
  EXPECT_EQ(chunk.runs, 3);
  ASSERT_EQ(chunk.failures.size(), 3U);
  ASSERT_EQ(chunk.not_converged.size(), 3U);
  for (std::int64_t i = 0; i < 3; ++i) {
    const RunFailure& failure = chunk.failures[static_cast<std::size_t>(i)];
    EXPECT_EQ(failure.run, 4 + i);
    EXPECT_EQ(failure.step, 7);
    EXPECT_EQ(failure.outcome, Outcome::not_positive_definite);
  }
  EXPECT_EQ(chunk.steps[5][Quantity::nees].count, 3);
  EXPECT_EQ(chunk.steps[5].nees_dof, 3 * 2);
  EXPECT_EQ(chunk.steps[5].nis_dof, 3 * 3);
  EXPECT_EQ(chunk.steps[6][Quantity::nees].count, 0);
  EXPECT_EQ(experiment.trace(4).steps.size(), 8U);
}

// ν = z − H x̂⁻ of what is shown, and the whole of a run is the sum of its steps.
TEST(LinearExperiment, WhatIsShownIsOneRun) {
  const LinearProblem problem = linear_problem(played_scenario(kPlayed)).value();
  const LinearExperiment experiment(problem, 30, NoiseSource(1, 1));
  const RunTrace trace = experiment.trace(2);
  double whole = 0.0;
  for (std::size_t k = 1; k <= 30; ++k) {
    const TraceStep &before = trace.steps[k - 1], &now = trace.steps[k];
    const Vector nu = now.z - problem.assumed.H * (problem.assumed.F * before.estimate);
    EXPECT_LT((nu - now.innovation()).norm(), 1e-9 * (1.0 + now.z.norm())) << k;
    EXPECT_NEAR(now.nis, nu.dot(now.S().inverse() * nu), 1e-8 * (1.0 + now.nis)) << k;
    whole += now.nees;
  }
  EXPECT_NEAR(experiment.run_chunk(2, 1).nees_of_runs.first.at(0), whole / 60.0, 1e-9 * whole);
}

}  // namespace
}  // namespace credence::internal
