#include "montecarlo/worlds/linear/intermittent_experiment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/filters/linear_filter.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/monobot/monobot_world.h"
#include "tests/montecarlo/lanes/missed_measurements.h"

namespace credence::internal {
namespace {

IntermittentExperiment experiment_of(const Scenario& s, InstructionSet set = best_instruction_set()) {
  return {monobot_problem(s), s.study.steps, NoiseSource(s.study.seed, noise_group(s), set)};
}

// A diffuse prior beside a small R: the Cholesky factor of S fails where one measurement at a time does not.
TEST(IntermittentExperiment, AVisitGoesOnWhereTheMatricesLoseSAndTheLanesDoNot) {
  Scenario s = intermittent_monobot(3, 0, 0.5);
  s.noise.initial_variance = 1e10;
  s.noise.measurement_variance = 1e-6;
  s.study.steps = 50;
  const IntermittentExperiment experiment = experiment_of(s);
  const StudyStatistics chunk = experiment.run_chunk(0, 64);
  EXPECT_LT(chunk.failures.size(), 64U) << "the lanes must get through, else nothing is compared";
  Index lost = 0;
  for (std::int64_t run = 0; run < 64; ++run) {
    const auto failure = std::ranges::find(chunk.failures, run, &RunFailure::run);
    Index steps = -1;
    const Outcome outcome = experiment.visit(run, [&](const TraceStep& step) {
      ++steps;
      lost += step.K.hasNaN() ? 1 : 0;
      EXPECT_EQ(step.P.rows(), 4);
    });
    EXPECT_EQ(outcome, failure == chunk.failures.end() ? Outcome::ok : failure->outcome) << "run " << run;
    EXPECT_EQ(steps, failure == chunk.failures.end() ? s.study.steps : failure->step) << "run " << run;
  }
  EXPECT_GT(lost, 0) << "S must have been lost, else this test tests nothing";
}

TEST(IntermittentExperiment, matrices_do_what_no_lane_does) {
  Scenario s = intermittent_monobot(3, 0, 0.6);
  s.filter.inflation = FilterInflation::map;
  s.filter.solution = InflationSolution::min_trace;
  ASSERT_FALSE(IntermittentLanes::support(monobot_problem(s)));
  const RunTrace trace = experiment_of(s).trace(5);
  ASSERT_EQ(trace.outcome, Outcome::ok);
  const LinearProblem problem = monobot_problem(s);
  LinearFilter filter(problem.assumed, problem.rule);
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const TraceStep& step = trace.steps[k];
    std::vector<Index> rows;
    for (Index i = 0; i < step.z.size(); ++i) {
      if (!std::isnan(step.z[i])) rows.push_back(i);
    }
    EXPECT_EQ(step.P, filter.step(rows).P);
    EXPECT_EQ(step.nis_dof, std::ssize(rows));
    const Vector e = step.truth - step.estimate;
    EXPECT_NEAR(step.nees / e.dot(step.P.llt().solve(e)), 1.0, 1e-9);
  }
}

TEST(IntermittentExperiment, instruction_sets_give_the_same_bits) {
  if (best_instruction_set() == InstructionSet::scalar) GTEST_SKIP() << "one instruction set cannot differ";
  for (const IntermittentCase& c : intermittent_cases()) {
    const StudyStatistics scalar = experiment_of(c.scenario, InstructionSet::scalar).run_chunk(64, 40);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      EXPECT_EQ(experiment_of(c.scenario, set).run_chunk(64, 40), scalar) << c.name;
    }
  }
}

TEST(IntermittentExperiment, a_run_alone_has_the_numbers_of_its_chunk) {
  for (const FilterInflation inflation : {FilterInflation::none, FilterInflation::map}) {
    Scenario s = intermittent_monobot(2, 0, 0.7);
    s.filter.inflation = inflation;
    const IntermittentExperiment experiment = experiment_of(s);
    const StudyStatistics one = experiment.run_chunk(7, 1);
    const RunTrace trace = experiment.trace(7);
    ASSERT_EQ(trace.steps.size(), static_cast<std::size_t>(s.study.steps) + 1);
    for (std::size_t k = 1; k < trace.steps.size(); ++k) {
      const TraceStep& step = trace.steps[k];
      const StepStatistics& of_chunk = one.steps[k - 1];
      EXPECT_EQ(step.nees, of_chunk[Quantity::nees].mean);
      EXPECT_EQ(of_chunk[Quantity::nis].count, step.nis_dof > 0 ? 1 : 0);
      EXPECT_EQ(step.nis, of_chunk[Quantity::nis].mean);
      EXPECT_EQ(step.nees_dof, of_chunk.nees_dof);
      EXPECT_EQ(step.nis_dof, of_chunk.nis_dof);
      EXPECT_EQ(step.nis_dof, step.innovation().size());
      if (step.nis_dof == 0) continue;
      EXPECT_NEAR(step.nis, step.innovation().dot(step.S().llt().solve(step.innovation())), 1e-9 * step.nis);
    }
  }
}

TEST(IntermittentExperiment, a_chunk_is_its_runs) {
  const Scenario s = intermittent_monobot(2, 0, 0.7);
  const IntermittentExperiment experiment = experiment_of(s);
  const StudyStatistics chunk = experiment.run_chunk(64, 64);
  StudyStatistics runs = experiment.run_chunk(64, 1);
  for (std::int64_t run = 65; run < 128; ++run) runs.merge(experiment.run_chunk(run, 1));
  for (std::size_t k = 0; k < chunk.steps.size(); ++k) {
    EXPECT_EQ(chunk.steps[k].nees_dof, runs.steps[k].nees_dof);
    EXPECT_EQ(chunk.steps[k].nis_dof, runs.steps[k].nis_dof);
    for (const Quantity q : {Quantity::nees, Quantity::nis, Quantity::trace_prior, Quantity::trace,
                             Quantity::trace_vehicle, Quantity::trace_landmarks}) {
      const Moments &a = chunk.steps[k][q], &b = runs.steps[k][q];
      EXPECT_EQ(a.count, b.count);
      if (q != Quantity::nis) {
        EXPECT_EQ(a.count, 64);
      }
      EXPECT_NEAR(a.mean, b.mean, 1e-13 * (1.0 + std::abs(b.mean)));
      EXPECT_NEAR(a.m2, b.m2, 1e-11 * (1.0 + b.m2));
    }
  }
}

TEST(IntermittentExperiment, an_optimal_filter_has_its_exact_means) {
  for (const Index anchors : {0, 1}) {
    Scenario s = intermittent_monobot(2, anchors, 0.5);
    s.study.steps = 100;
    const IntermittentExperiment experiment = experiment_of(s);
    ASSERT_TRUE(experiment.is_optimal());
    const double n = 3.0, m = 2.0 + static_cast<double>(anchors), p = 0.5;
    constexpr std::int64_t kRuns = 10'048;
    const StudyStatistics statistics = experiment.run_chunk(0, kRuns);
    const double runs = kRuns;
    for (std::size_t k = 9; k < 100; k += 10) {
      EXPECT_NEAR(statistics.steps[k][Quantity::nees].mean, n, 5.0 * std::sqrt(2.0 * n / runs)) << k;
      // of a run: 0, or χ² of a binomial number of dof
      const Moments& nis = statistics.steps[k][Quantity::nis];
      const double of_nis = std::sqrt((2.0 * m * p + m * p * (1.0 - p)) / runs);
      EXPECT_NEAR(static_cast<double>(nis.count) * nis.mean / runs, m * p, 5.0 * of_nis) << k;
      const double any = 1.0 - std::pow(1.0 - p, m);
      EXPECT_NEAR(static_cast<double>(nis.count), runs * any, 5.0 * std::sqrt(runs * any * (1.0 - any))) << k;
      EXPECT_NEAR(static_cast<double>(statistics.steps[k].nis_dof), runs * m * p,
                  5.0 * std::sqrt(runs * m * p * (1.0 - p)))
          << k;
    }
  }
}

/// tr(P⁻¹ Σ) of a filter given what it saw: Σ is the true covariance of its error.
TEST(IntermittentExperiment, a_wrong_filter_has_its_exact_mean_given_what_it_saw) {
  Scenario s = intermittent_monobot(2, 0, 0.6);
  s.filter.measurement_scale = 0.5;
  s.filter.inflation = FilterInflation::map;
  const IntermittentExperiment experiment = experiment_of(s);
  EXPECT_FALSE(experiment.is_optimal());
  const IntermittentProblem problem = monobot_problem(s);
  const auto steps = static_cast<std::size_t>(s.study.steps);
  std::vector<Moments> excess(steps);
  for (std::int64_t run = 0; run < 2000; ++run) {
    LinearFilter filter(problem.assumed, problem.rule);
    Matrix Sigma = problem.truth.P0;
    experiment.visit(run, [&, k = std::size_t{0}](const TraceStep& step) mutable {
      if (k++ == 0) return;
      std::vector<Index> rows;
      for (Index i = 0; i < step.z.size(); ++i) {
        if (!std::isnan(step.z[i])) rows.push_back(i);
      }
      const LinearFilterStep& f = filter.step(rows);
      const Matrix A = Matrix::Identity(3, 3) - f.K * problem.truth.H(rows, Eigen::all);
      Sigma(0, 0) += problem.truth.Q(0, 0);
      Sigma = (A * Sigma * A.transpose() + f.K * problem.truth.R(rows, rows) * f.K.transpose()).eval();
      excess[k - 2].add(step.nees - f.P.llt().solve(Sigma).trace());
    });
  }
  for (std::size_t k = 4; k < steps; k += 5) {
    const double error = std::sqrt(excess[k].variance() / 2000.0);
    EXPECT_LT(std::abs(excess[k].mean), 5.0 * error) << k;
    EXPECT_LT(error, 0.3) << k;  // the mean excess over n itself is more than 1.5
  }
}

TEST(IntermittentExperiment, runs_that_fail_are_counted_named_and_end_there) {
  Scenario s = intermittent_monobot(2, 0, 0.01);
  s.noise.process_variance = 1e148;  // beyond kLargestTrace where nothing is seen for long
  s.study.steps = 4000;
  const IntermittentExperiment experiment = experiment_of(s);
  const StudyStatistics statistics = experiment.run_chunk(0, 40);
  ASSERT_EQ(statistics.failures.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(statistics.failures[i].run, static_cast<std::int64_t>(i));
    EXPECT_EQ(statistics.failures[i].outcome, Outcome::not_positive_definite);
  }
  for (const RunFailure& failure : {statistics.failures.front(), statistics.failures.back()}) {
    const RunTrace trace = experiment.trace(failure.run);
    EXPECT_EQ(trace.outcome, failure.outcome);
    EXPECT_EQ(std::ssize(trace.steps) - 1, failure.step);
    EXPECT_EQ(trace.steps.back().nees_dof, 0);
    EXPECT_EQ(trace.steps.back().nis_dof, 0);
  }
  for (std::size_t k = 0; k < statistics.steps.size(); ++k) {
    std::int64_t alive = 0;
    for (const RunFailure& f : statistics.failures) alive += static_cast<std::int64_t>(k) + 1 < f.step;
    ASSERT_EQ(statistics.steps[k][Quantity::nees].count, alive) << k;
    ASSERT_EQ(statistics.steps[k].nees_dof, 3 * alive) << k;
  }
}

TEST(IntermittentExperiment, a_sure_detection_is_the_shared_filter) {
  const Scenario s = intermittent_monobot(2, 1, 1.0);
  const NoiseSource source(s.study.seed, 0);
  const LinearExperiment shared(monobot_problem(s), s.study.steps, source);
  const IntermittentExperiment own(monobot_problem(s), s.study.steps, source);
  const RunTrace a = shared.trace(11), b = own.trace(11);
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    EXPECT_EQ(a.steps[k].truth, b.steps[k].truth);
    EXPECT_LT((a.steps[k].estimate - b.steps[k].estimate).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((a.steps[k].P - b.steps[k].P).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(a.steps[k].nees, b.steps[k].nees, 1e-10);
    EXPECT_NEAR(a.steps[k].nis, b.steps[k].nis, 1e-10);
  }
}

}  // namespace
}  // namespace credence::internal
