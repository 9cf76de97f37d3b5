#include "montecarlo/lanes/intermittent_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/montecarlo/engine/allocation_count.h"
#include "tests/montecarlo/lanes/missed_measurements.h"

namespace credence::internal {
namespace {

using WideMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// One run of a monobot in extended precision, the way of the textbook: all measurements of a step together,
/// Joseph's form.
class WideRun {
 public:
  WideRun(const IntermittentProblem& problem, const NoiseSource& source, std::int64_t run)
      : problem_(problem), source_(source), run_(run) {
    const Index n = problem.truth.state_dim();
    Vector normals(n);
    source.normals(run, 0, NoisePurpose::initial, {normals.data(), static_cast<std::size_t>(n)});
    e = std::sqrt(static_cast<long double>(problem.truth.P0(0, 0))) * normals.cast<long double>();
    P = problem.assumed.P0.cast<long double>();
  }

  void step(Index k) {
    const LinearModel &truth = problem_.truth, &assumed = problem_.assumed;
    const Index n = truth.state_dim(), m = truth.measurement_dim(), first = k - (k - 1) % 4;
    const auto root = [](double variance) { return std::sqrt(static_cast<long double>(variance)); };
    e[0] += root(truth.Q(0, 0)) * source_.normal(run_, k, NoisePurpose::process, 0);
    P(0, 0) += assumed.Q(0, 0);
    if (problem_.rule.constant.size() > 0) P += problem_.rule.constant.cast<long double>();
    decorrelate();
    trace_prior = P.trace();

    std::vector<double> events(static_cast<std::size_t>(4 * m));
    source_.events_of_four_steps(run_, first, NoisePurpose::detection, problem_.detection_probability, m,
                                 events);
    rows.clear();
    for (Index i = 0; i < m; ++i) {
      if (events[static_cast<std::size_t>((k - first) * m + i)] == 1.0) rows.push_back(i);
    }
    nis = 0.0;
    if (!rows.empty()) {
      const Index seen = std::ssize(rows);
      const WideMatrix H = truth.H(rows, Eigen::all).cast<long double>();
      WideVector nu = H * e;
      for (Index i = 0; i < seen; ++i) {
        nu[i] += root(truth.R(0, 0)) *
                 source_.normal(run_, k, NoisePurpose::measurement, rows[static_cast<std::size_t>(i)]);
      }
      const WideMatrix R = assumed.R(0, 0) * WideMatrix::Identity(seen, seen), S = H * P * H.transpose() + R;
      const WideMatrix K = S.llt().solve(H * P).transpose();
      const WideMatrix A = WideMatrix::Identity(n, n) - K * H;
      e -= K * nu;
      P = (A * P * A.transpose() + K * R * K.transpose()).eval();
      P = (0.5L * (P + P.transpose())).eval();
      nis = nu.dot(S.llt().solve(nu));
    }
    nees = e.dot(P.llt().solve(e));
  }

  WideVector e;
  WideMatrix P;
  long double nees = 0.0, nis = 0.0, trace_prior = 0.0;
  std::vector<Index> rows;

 private:
  /// The pairwise sum of blocks of one state.
  void decorrelate() {
    const Inflation inflation = problem_.rule.inflation;
    if (inflation == Inflation::none) return;
    const Index first = inflation == Inflation::full ? 0 : 1;
    for (Index i = first; i < P.rows(); ++i) {
      for (Index j = first; j < i; ++j) {
        const long double c = std::abs(P(i, j));
        P(i, i) += c;
        P(j, j) += c;
        P(i, j) = P(j, i) = 0.0;
      }
    }
  }

  const IntermittentProblem& problem_;
  const NoiseSource& source_;
  std::int64_t run_;
};

TEST(IntermittentLanes, are_the_textbook_filter_to_rounding) {
  for (const IntermittentCase& c : intermittent_cases()) {
    SCOPED_TRACE(c.name);
    const IntermittentProblem problem = monobot_problem(c.scenario);
    const NoiseSource source(c.scenario.study.seed, noise_group(c.scenario));
    ASSERT_TRUE(IntermittentLanes::support(problem));
    IntermittentLanes lanes(problem, source);
    lanes.start(3, IntermittentLanes::kLanes);
    WideRun first(problem, source, 3), last(problem, source, 34);
    for (Index k = 1; k <= c.scenario.study.steps; ++k) {
      ASSERT_EQ(lanes.advance(1), 1);
      for (const auto& [run, lane] : {std::pair<WideRun*, int>{&first, 0}, {&last, 31}}) {
        run->step(k);
        const WideMatrix P = lanes.covariance(lane).cast<long double>();
        const WideVector e = lanes.error(lane).cast<long double>();
        EXPECT_LT((P - run->P).cwiseAbs().maxCoeff(), 1e-13L * run->P.cwiseAbs().maxCoeff()) << k;
        EXPECT_LT((e - run->e).cwiseAbs().maxCoeff(), 1e-12L * run->e.cwiseAbs().maxCoeff()) << k;
        EXPECT_NEAR(lanes.value(kNeesValue, lane), static_cast<double>(run->nees),
                    1e-10 * (1.0 + static_cast<double>(run->nees)))
            << k;
        EXPECT_NEAR(lanes.value(kNisValue, lane), static_cast<double>(run->nis),
                    1e-10 * (1.0 + static_cast<double>(run->nis)))
            << k;
        EXPECT_NEAR(lanes.value(kTracePriorValue, lane), static_cast<double>(run->trace_prior),
                    1e-12 * static_cast<double>(run->trace_prior));
        const double trace = lanes.covariance(lane).trace();
        EXPECT_NEAR(lanes.value(kTraceValue, lane), trace, 1e-14 * trace);
        EXPECT_EQ(lanes.value(kVehicleValue, lane), lanes.covariance(lane)(0, 0));
        std::vector<Index> rows;
        for (Index i = 0; i < problem.truth.measurement_dim(); ++i) {
          if (lanes.seen(i, lane)) rows.push_back(i);
        }
        EXPECT_EQ(rows, run->rows);
      }
    }
  }
}

TEST(IntermittentLanes, a_vague_prior_costs_no_digits) {
  Scenario s = intermittent_monobot(2, 1, 0.8);
  s.noise.initial_variance = 1e14;  // 1e15 times the variance of a measurement
  const IntermittentProblem problem = monobot_problem(s);
  const NoiseSource source(1, 0);
  IntermittentLanes lanes(problem, source);
  lanes.start(0, 1);
  WideRun wide(problem, source, 0);
  for (Index k = 1; k <= s.study.steps; ++k) {
    lanes.advance(1);
    wide.step(k);
    const WideMatrix P = lanes.covariance(0).cast<long double>();
    for (Index i = 0; i < P.rows(); ++i) EXPECT_LT(std::abs(P(i, i) / wide.P(i, i) - 1.0L), 1e-9L) << k;
  }
}

TEST(IntermittentLanes, a_tile_of_runs_allocates_nothing) {
  const Scenario s = intermittent_monobot(5, 1, 0.7);
  IntermittentLanes lanes(monobot_problem(s), NoiseSource(1, 0));
  StudyStatistics statistics;
  statistics.steps.resize(40);
  lanes.start(0, IntermittentLanes::kLanes);
  const std::int64_t before = allocations_of_this_thread();
  for (Index done = 0; done < 40;) {
    done += lanes.advance(40 - done);
    lanes.add_to(statistics);
  }
  EXPECT_EQ(allocations_of_this_thread() - before, 0);
}

TEST(IntermittentLanes, refuse_what_they_do_not_have) {
  Scenario s = intermittent_monobot(2, 0, 0.5);
  s.filter.inflation = FilterInflation::map;
  s.filter.solution = InflationSolution::sequential;
  EXPECT_THROW(IntermittentLanes(monobot_problem(s), NoiseSource(1, 0)), std::invalid_argument);
  EXPECT_FALSE(IntermittentLanes::support(monobot_problem([&] {
    Scenario exact = intermittent_monobot(2, 0, 0.5);
    exact.noise.measurement_variance = 0.0;
    return exact;
  }())));
  IntermittentProblem problem = monobot_problem(intermittent_monobot(2, 0, 0.5));
  ASSERT_TRUE(IntermittentLanes::support(problem));
  const auto supported = [&](void (*change)(IntermittentProblem&)) {
    IntermittentProblem other = problem;
    change(other);
    return IntermittentLanes::support(other);
  };
  EXPECT_FALSE(supported([](IntermittentProblem& p) { p.truth.F(0, 0) = 0.9; }));
  EXPECT_FALSE(supported([](IntermittentProblem& p) { p.assumed.R(0, 1) = p.assumed.R(1, 0) = 0.01; }));
  EXPECT_FALSE(supported([](IntermittentProblem& p) { p.assumed.P0(1, 1) = 2.0; }));
  EXPECT_FALSE(supported([](IntermittentProblem& p) { p.assumed.P0.setZero(); }));
  EXPECT_FALSE(supported([](IntermittentProblem& p) { p.measurement_delay = 1; }));
  EXPECT_TRUE(supported([](IntermittentProblem& p) { p.truth.R.setZero(); })) << "the truth may be exact";
  EXPECT_TRUE(supported([](IntermittentProblem& p) { p.rule.inflation = Inflation::full; }));
}

IntermittentProblem two_landmarks() {
  Scenario s = intermittent_monobot(2, 0, 0.6);
  s.filter.inflation = FilterInflation::map;
  return monobot_problem(s);
}

TEST(IntermittentLanes, give_the_same_bits_with_every_instruction_set) {
  for (const IntermittentCase& c : intermittent_cases()) {
    const IntermittentProblem problem = monobot_problem(c.scenario);
    IntermittentLanes scalar(problem, NoiseSource(3, 1, InstructionSet::scalar));
    scalar.start(5, IntermittentLanes::kLanes);
    for (Index done = 0; done < 12;) done += scalar.advance(12 - done);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      IntermittentLanes lanes(problem, NoiseSource(3, 1, set));
      lanes.start(5, IntermittentLanes::kLanes);
      for (Index done = 0; done < 12;) done += lanes.advance(12 - done);
      for (int lane = 0; lane < IntermittentLanes::kLanes; ++lane) {
        ASSERT_EQ(lanes.covariance(lane), scalar.covariance(lane)) << c.name << ", lane " << lane;
        ASSERT_EQ(lanes.error(lane), scalar.error(lane)) << c.name << ", lane " << lane;
        ASSERT_EQ(lanes.value(kNeesValue, lane), scalar.value(kNeesValue, lane)) << c.name;
      }
    }
  }
}

// Run 13 is in lane 10 of the runs from 3 on, in lane 0 of those from 13 on, and there alone.
TEST(IntermittentLanes, depend_each_on_its_own_run_alone) {
  const IntermittentProblem problem = two_landmarks();
  const NoiseSource source(7, 0);
  IntermittentLanes many(problem, source), few(problem, source);
  many.start(3, IntermittentLanes::kLanes);
  few.start(0, IntermittentLanes::kLanes);  // something else before
  few.advance(3);
  few.start(13, 1);
  for (Index k = 1; k <= 20; ++k) {
    ASSERT_EQ(many.advance(1), 1);
    ASSERT_EQ(few.advance(1), 1);
    EXPECT_EQ(many.covariance(10), few.covariance(0)) << k;
    EXPECT_EQ(many.error(10), few.error(0)) << k;
    EXPECT_EQ(many.value(kNisValue, 10), few.value(kNisValue, 0)) << k;
    for (Index row = 0; row < 2; ++row) EXPECT_EQ(many.seen(row, 10), few.seen(row, 0)) << k;
  }
}

TEST(IntermittentLanes, advance_by_as_many_steps_as_are_drawn_and_no_more_than_asked) {
  const IntermittentProblem problem = two_landmarks();
  const NoiseSource source(7, 0);
  IntermittentLanes at_once(problem, source), one_by_one(problem, source);
  at_once.start(0, 4);
  one_by_one.start(0, 4);
  for (Index done = 0; done < 50;) {
    const Index steps = at_once.advance(50 - done);
    ASSERT_GE(steps, 1);
    ASSERT_LE(steps, 50 - done);
    done += steps;
  }
  for (Index k = 0; k < 50; ++k) ASSERT_EQ(one_by_one.advance(1), 1);
  for (int lane = 0; lane < 4; ++lane) {
    EXPECT_EQ(at_once.covariance(lane), one_by_one.covariance(lane));
    EXPECT_EQ(at_once.error(lane), one_by_one.error(lane));
  }
}

TEST(IntermittentLanes, add_the_runs_that_there_are) {
  const IntermittentProblem problem = two_landmarks();
  IntermittentLanes lanes(problem, NoiseSource(7, 0));
  constexpr int kRuns = 5;
  lanes.start(40, kRuns);
  StudyStatistics statistics;
  statistics.steps.resize(9);
  std::vector<double> nees(kRuns, 0.0);
  for (std::size_t k = 0; k < 9; ++k) {
    ASSERT_EQ(lanes.advance(1), 1);
    lanes.add_to(statistics);
    double mean = 0.0, nis = 0.0;
    std::int64_t seen = 0, with_any = 0;
    for (int lane = 0; lane < kRuns; ++lane) {
      nees[static_cast<std::size_t>(lane)] += lanes.value(kNeesValue, lane);
      mean += lanes.value(kNeesValue, lane) / kRuns;
      const int rows = (lanes.seen(0, lane) ? 1 : 0) + (lanes.seen(1, lane) ? 1 : 0);
      seen += rows;
      if (rows == 0) continue;
      ++with_any;
      nis += lanes.value(kNisValue, lane);
    }
    const StepStatistics& step = statistics.steps[k];
    EXPECT_EQ(step[Quantity::nees].count, kRuns);
    EXPECT_NEAR(step[Quantity::nees].mean, mean, 1e-13 * mean);
    EXPECT_EQ(step.nees_dof, 3 * kRuns);
    EXPECT_EQ(step.nis_dof, seen);
    EXPECT_EQ(step[Quantity::nis].count, with_any);
    EXPECT_NEAR(step[Quantity::nis].mean * static_cast<double>(with_any), nis, 1e-12);
  }
  lanes.add_runs_to(statistics);
  ASSERT_EQ(statistics.nees_of_runs.first.size(), static_cast<std::size_t>(kRuns));
  for (std::size_t i = 0; i < kRuns; ++i) {
    EXPECT_DOUBLE_EQ(statistics.nees_of_runs.first[i], nees[i] / 27.0) << "of nine steps with three states";
  }
}

// All 32 at once by sums over the lanes, 31 one by one: of the same runs.
TEST(IntermittentLanes, add_a_full_tile_as_its_runs) {
  const IntermittentProblem problem = two_landmarks();
  IntermittentLanes lanes(problem, NoiseSource(9, 0));
  StudyStatistics tile, parts;
  for (StudyStatistics* statistics : {&tile, &parts}) statistics->steps.resize(6);
  const auto add = [&](std::int64_t first, int runs, StudyStatistics& statistics) {
    lanes.start(first, runs);
    for (Index done = 0; done < 6;) {
      done += lanes.advance(6 - done);
      lanes.add_to(statistics);
    }
  };
  add(0, 32, tile);
  add(0, 31, parts);
  add(31, 1, parts);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(tile.steps[k].nis_dof, parts.steps[k].nis_dof);
    EXPECT_EQ(tile.steps[k].nees_dof, parts.steps[k].nees_dof);
    for (const Quantity q : {Quantity::nees, Quantity::nis, Quantity::trace_prior, Quantity::trace,
                             Quantity::trace_vehicle, Quantity::trace_landmarks}) {
      const Moments &a = tile.steps[k][q], &b = parts.steps[k][q];
      EXPECT_EQ(a.count, b.count);
      EXPECT_NEAR(a.mean, b.mean, 1e-13 * (1.0 + std::abs(b.mean)));
      EXPECT_NEAR(a.m2, b.m2, 1e-11 * (1.0 + b.m2));
    }
  }
}

TEST(IntermittentLanes, a_run_whose_variance_grows_beyond_all_numbers_ends_there_and_is_named) {
  Scenario s = intermittent_monobot(2, 0, 0.0);  // sees nothing
  s.noise.process_variance = 1e142;
  s.filter.process_scale = 3e7;
  IntermittentLanes lanes(monobot_problem(s), NoiseSource(1, 0));
  lanes.start(64, 2);
  StudyStatistics statistics;
  statistics.steps.resize(8);
  for (Index done = 0; done < 8;) {
    done += lanes.advance(8 - done);
    lanes.add_to(statistics);
  }
  // Its P of the vehicle is 1 + 3e149 k, past kLargestTrace at k = 4.
  ASSERT_EQ(statistics.failures.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(statistics.failures[i].run, 64 + static_cast<std::int64_t>(i));
    EXPECT_EQ(statistics.failures[i].step, 4);
    EXPECT_EQ(lanes.outcome(static_cast<int>(i)), Outcome::not_positive_definite);
  }
  EXPECT_EQ(statistics.steps[2][Quantity::nees].count, 2);
  EXPECT_EQ(statistics.steps[3][Quantity::nees].count, 0);
  EXPECT_EQ(statistics.steps[0][Quantity::nis].count, 0) << "nothing seen";
  lanes.add_runs_to(statistics);
  EXPECT_TRUE(statistics.nees_of_runs.first.empty());
}

TEST(IntermittentProblem, has_one_model_or_those_of_a_period) {
  IntermittentProblem problem = two_landmarks();
  EXPECT_FALSE(problem.is_periodic());
  EXPECT_EQ(problem.truth_period().size(), 1U);
  problem.truth_later = problem.assumed_later = {problem.truth, problem.truth};
  problem.truth_later[1].R *= 2.0;
  problem.assumed_later[0].Q *= 3.0;
  EXPECT_TRUE(problem.is_periodic());
  ASSERT_EQ(problem.truth_period().size(), 3U);
  EXPECT_EQ(problem.truth_period()[0].R, problem.truth.R);
  EXPECT_EQ(problem.truth_period()[2].R, 2.0 * problem.truth.R);
  EXPECT_EQ(problem.assumed_period()[1].Q, 3.0 * problem.truth.Q);
  EXPECT_FALSE(IntermittentLanes::support(problem));
}

}  // namespace
}  // namespace credence::internal
