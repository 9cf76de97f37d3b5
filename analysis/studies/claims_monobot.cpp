#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/stability/boundedness.h"
#include "analysis/stability/exact_moments.h"
#include "analysis/stability/ranks.h"
#include "analysis/stability/riccati.h"
#include "analysis/stability/stability_analysis.h"
#include "analysis/studies/claims.h"
#include "core/append_item.h"
#include "core/enum_words.h"
#include "core/filters/linear_filter.h"
#include "core/inflation/rank_inflation.h"
#include "core/number_text.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/monobot/monobot_world.h"

namespace credence::internal {
namespace {

constexpr double kQ = 0.1, kR = 0.1, kP0 = 1.0;
constexpr Index kMonobotSteps = 100, kLong = 4000;

LinearModel monobot(Index landmarks, Index anchors = 0) {
  return monobot_model(landmarks, anchors, kQ, kR, kP0);
}

const InflationRule kNone{};
const InflationRule kFull{.inflation = Inflation::full, .constant = {}};
const InflationRule kMap{.inflation = Inflation::map, .constant = {}};
const InflationRule kMapExact{
    .inflation = Inflation::map, .solution = InflationSolution::min_trace, .constant = {}};

RiccatiProblem problem_of(const LinearModel& model) {
  return {.F = model.F, .H = model.H, .Qt = model.G * model.Q * model.G.transpose(), .R = model.R};
}

double landmark_gain(const Matrix& K) { return K.bottomRows(K.rows() - 1).cwiseAbs().maxCoeff(); }

ClaimVerdict holds_if(bool condition) { return condition ? ClaimVerdict::holds : ClaimVerdict::fails; }

Claim unit_eigenvalue() {
  const LinearModel model = monobot(1);
  const LinearFilterStep step = linear_filter_steps(model, kNone, kMonobotSteps).back();
  const Eigen::VectorXcd eigenvalues = closed_loop_eigenvalues(model.F, step.K, model.H);
  const double ratio = kR / step.S(0, 0);
  const double error = std::max(std::abs(eigenvalues[0] - 1.0), std::abs(eigenvalues[1] - ratio));
  return {.id = "unit-eigenvalue",
          .source = "eqs (14), (15)",
          .statement =
              "partially observable, one landmark: F − KH has the eigenvalue 1, the other is R/s, s = "
              "H P Hᵀ + R",
          .measured = fmt::format("eigenvalues {:.9f} and {:.9f}, R/s = {:.9f}: they agree to {}. Eq. (14) "
                                  "as printed uses σ_w² for two things; this is the form without the clash",
                                  eigenvalues[0].real(), eigenvalues[1].real(), ratio, number_text(error, 1)),
          .verdict = holds_if(error < 1e-12)};
}

Claim error_of_one_run() {
  const LinearModel model = monobot(1);
  const LinearExperiment experiment({{model, model, kNone}, monobot_scene(model, true)}, kLong,
                                    NoiseSource(1, 0));
  double at_100 = 0.0, at_half = 0.0, last = 0.0;
  Index k = 0;
  experiment.visit(0, [&](const TraceStep& step) {
    const double error = step.estimate[1] - step.truth[1];
    if (k == kMonobotSteps) at_100 = error;
    if (k == kLong / 2) at_half = error;
    last = error;
    ++k;
  });
  return {.id = "bounded-error",
          .source = "section 3, Figure 1",
          .statement =
              "partially observable: the error of a run does not vanish and does not grow, it tends to a "
              "constant that is not zero",
          .measured = fmt::format("run 0 of seed 1: landmark error {} m at step {}", number_text(at_100),
                                  kMonobotSteps),
          .long_run = fmt::format("{} m at step {}, {} m at step {}", number_text(at_half), kLong / 2,
                                  number_text(last), kLong),
          .verdict = holds_if(std::abs(last) > 0.01 && std::abs(last - at_half) < 0.1 * std::abs(last))};
}

Claim limit_depends_on_initial() {
  const LinearModel model = monobot(2);
  const RiccatiProblem problem = problem_of(model);
  const RiccatiSolution one = solve_riccati(problem, model.P0), four = solve_riccati(problem, 4.0 * model.P0);
  return {.id = "psd-limit",
          .source = "eq. (17), section 3",
          .statement = "partially observable: the Riccati equation has a psd solution that depends on P0",
          .measured =
              fmt::format("solution “{}”; trace of the limit {:.6f} m² from P0 = I, {:.6f} m² from P0 = "
                          "4 I; residual {}. The last term of (17) must read K_p R K_pᵀ",
                          to_string(one.kind), one.P.trace(), four.P.trace(), number_text(one.residual, 1)),
          .verdict = holds_if(one.kind == RiccatiKind::depends_on_initial &&
                              std::abs(four.P.trace() / one.P.trace() - 1.0) > 0.01)};
}

Claim controllability_rank() {
  std::string ranks;
  bool all_one = true;
  for (const Index landmarks : {1, 2, 5, 12}) {
    const LinearModel model = monobot(landmarks);
    const Index rank = controllability(model.F, model.G, model.Q).decision.rank;
    all_one = all_one && rank == 1;
    append_item(ranks, fmt::format("{}: {}", counted(landmarks, "landmark"), rank));
  }
  return {.id = "controllability-rank",
          .source = "section 4",
          .statement = "monobot: rank C is the dimension of the vehicle, whatever the number of landmarks",
          .measured = ranks,
          .verdict = holds_if(all_one)};
}

Claim observability_rank() {
  std::string ranks;
  bool as_claimed = true;
  for (const Index landmarks : {1, 2, 5, 12}) {
    const LinearModel free = monobot(landmarks), anchored = monobot(landmarks, 1);
    const Index partial = observability(free.F, free.H).decision.rank;
    const Index full = observability(anchored.F, anchored.H).decision.rank;
    as_claimed = as_claimed && partial == landmarks && full == landmarks + 1;
    append_item(ranks, fmt::format("n = {}: {} and {}", landmarks + 1, partial, full), "; ");
  }
  return {.id = "observability-rank",
          .source = "section 4",
          .statement = "monobot: rank O = n − 1; with one landmark as anchor rank O = n",
          .measured = ranks,
          .verdict = holds_if(as_claimed)};
}

Claim gains_die_out() {
  const auto steps = linear_filter_steps(monobot(2), kNone, kLong);
  const double early = landmark_gain(steps[kMonobotSteps - 1].K), late = landmark_gain(steps.back().K);
  return {.id = "gains-die-out",
          .source = "Figure 1",
          .statement = "without inflation the gains of the landmarks tend to zero",
          .measured = fmt::format("largest landmark gain {:.6f} at step {}", early, kMonobotSteps),
          .long_run = fmt::format("{:.6f} at step {}: it falls as 1/k", late, kLong),
          .verdict = holds_if(late < 0.05 * early)};
}

Claim full_is_unbounded() {
  std::string rates;
  bool as_claimed = true;
  for (const Index landmarks : {1, 2, 3}) {
    const auto steps = linear_filter_steps(monobot(landmarks), kFull, kLong);
    const auto rate = [&](auto trace) {
      constexpr Index kHalf = kLong / 2;
      return (trace(steps.back()) - trace(steps[kHalf - 1])) / static_cast<double>(kLong - kHalf);
    };
    const double prior = rate([](const LinearFilterStep& s) { return s.P_prior.trace(); });
    const double posterior = rate([](const LinearFilterStep& s) { return s.P.trace(); });
    as_claimed = as_claimed && std::abs(prior / kQ - 1.0) < 0.01 &&
                 std::abs(posterior * static_cast<double>(landmarks + 1) / kQ - 1.0) < 0.01;
    append_item(rates, fmt::format("N = {}: {:.5f} and {:.5f} m²", landmarks, prior, posterior));
  }
  const double at_100 = linear_filter_steps(monobot(2), kFull, kMonobotSteps).back().P_prior.trace();
  return {.id = "full-unbounded",
          .source = "Figure 2",
          .statement = "partially observable, everything decorrelated: the covariance grows without bound",
          .measured = fmt::format("N = 2: trace of the prior {:.4f} m² at step {}", at_100, kMonobotSteps),
          .long_run = fmt::format("growth a step of the prior (Q = {}) and of the posterior (Q/(N+1)): {}",
                                  kQ, rates),
          .verdict = holds_if(as_claimed)};
}

constexpr Index kLandmarksInTurn = 3, kStepsInTurn = 999;

/// One landmark at a time, in turn: the trace of the prior after so many steps.
double trace_in_turn(const InflationRule& rule) {
  LinearModel model = monobot(kLandmarksInTurn);
  const Matrix all = model.H;
  model.R = Matrix::Constant(1, 1, kR);
  double trace = 0.0;
  for (Index k = 0; k < kStepsInTurn; ++k) {
    model.H = all.row(k % kLandmarksInTurn);
    const LinearFilterStep step = linear_filter_steps(model, rule, 1).front();
    trace = step.P_prior.trace();
    model.P0 = step.P;
  }
  return trace;
}

Claim map_is_bounded() {
  const auto steps = linear_filter_steps(monobot(2), kMap, kLong);
  const double gain = landmark_gain(steps[kMonobotSteps - 1].K), late = landmark_gain(steps.back().K);
  const double pairwise = trace_in_turn(kMap), exact = trace_in_turn(kMapExact);
  const bool bounded =
      std::abs(steps.back().P_prior.trace() / steps[kMonobotSteps - 1].P_prior.trace() - 1.0) < 1e-6;
  return {
      .id = "map-bounded",
      .source = "Figure 3",
      .statement =
          "partially observable, only the map decorrelated: the covariance stays bounded, with "
          "constant gains that are not zero",
      .measured =
          fmt::format("N = 2, both landmarks always in view: prior {:.6f} m² and largest landmark gain "
                      "{:.6f} at step {}",
                      steps[kMonobotSteps - 1].P_prior.trace(), gain, kMonobotSteps),
      .long_run = fmt::format(
          "{:.6f} m² and {:.6f} at step {}. But three landmarks seen in turn, one a step: {:.1f} m² after {} "
          "steps with the pairwise sum, {:.2f} m² with the exact minimal trace. Needs the exact minimal "
          "trace, or all landmarks in view",
          steps.back().P_prior.trace(), late, kLong, pairwise, kStepsInTurn, exact),
      .verdict = bounded && gain > 0.1 && late > 0.1
                     ? (pairwise > 10.0 * exact ? ClaimVerdict::conditional : ClaimVerdict::holds)
                     : ClaimVerdict::fails};
}

Claim one_landmark_map() {
  const auto optimal = linear_filter_steps(monobot(1), kNone, kMonobotSteps);
  const auto map = linear_filter_steps(monobot(1), kMap, kMonobotSteps);
  double difference = 0.0;
  for (std::size_t k = 0; k < optimal.size(); ++k) {
    difference = std::max(difference, (optimal[k].P - map[k].P).cwiseAbs().maxCoeff());
  }
  return {.id = "one-landmark-map",
          .source = "Figure 3",
          .statement = "with one landmark, decorrelating the map alone changes nothing",
          .measured = fmt::format("largest difference of P over {} steps: {}", kMonobotSteps,
                                  number_text(difference, 2)),
          .verdict = holds_if(difference == 0.0)};
}

Claim larger_variance() {
  const Matrix optimal = linear_filter_steps(monobot(2), kNone, kMonobotSteps).back().P;
  const auto steps = linear_filter_steps(monobot(2), kMap, kMonobotSteps);
  const ExactMoments exact = exact_moments(monobot(2), steps).back();
  const Matrix& P = steps.back().P;
  return {.id = "suboptimal-variance",
          .source = "Figure 3",
          .statement =
              "the price of decorrelating the map is a larger variance of the landmarks; the vehicle's "
              "stays",
          .measured =
              fmt::format("variance of the first landmark {:.6f} m² (optimal {:.6f}), of the vehicle {:.6f} "
                          "m² ({:.6f}); its real mean squared error is {:.6f} m², E[NEES] {:.4f} of 3",
                          P(1, 1), optimal(1, 1), P(0, 0), optimal(0, 0), exact.Sigma(1, 1), exact.nees),
          .verdict = holds_if(P(1, 1) > optimal(1, 1) && std::abs(P(0, 0) / optimal(0, 0) - 1.0) < 1e-6)};
}

struct ConditionCount {
  int cells = 0, exact_wrong = 0, paper_wrong = 0, paper_too_strict = 0;
};

/// All ranks of a constant generic, map-only, noise-containing or difference-only ΔP.
ConditionCount count_conditions() {
  ConditionCount count;
  for (const Index landmarks : {1, 2, 3, 4}) {
    for (const Index anchors : {0, 1}) {
      const LinearModel model = monobot(landmarks, anchors);
      for (const InflationRange range : {InflationRange::generic, InflationRange::map,
                                         InflationRange::with_vehicle, InflationRange::difference}) {
        const Index least = range == InflationRange::with_vehicle ? 1 : 0;
        for (Index rank = least; rank <= max_inflation_rank(model.layout, range); ++rank) {
          const Matrix inflation =
              rank_inflation(model.layout, model.G, {.rank = rank, .range = range, .scale = kQ});
          RiccatiProblem problem = problem_of(model);
          problem.Qt += inflation;
          const bool bounded = measure_boundedness(problem, model.P0).bounded;
          const ExactBoundedness exact = exact_boundedness(problem.F, problem.H, problem.Qt);
          const bool paper = paper_boundedness(inflation, exact.observability.rank).bounded();
          ++count.cells;
          count.exact_wrong += exact.bounded() != bounded ? 1 : 0;
          count.paper_wrong += paper && !bounded ? 1 : 0;
          count.paper_too_strict += !paper && bounded ? 1 : 0;
        }
      }
    }
  }
  return count;
}

Claim rank_condition() {
  const ConditionCount c = count_conditions();
  const bool paper_right = c.paper_wrong == 0 && c.paper_too_strict == 0;
  return {
      .id = "rank-condition",
      .source = "eq. (22)",
      .statement = "the filter is stable when rank ΔP ≤ rank O",
      .measured = fmt::format(
          "{} cells (1 to 4 landmarks, free and anchored, every rank of a constant ΔP in four ranges): (22) "
          "says bounded where P grows in {}, and unbounded where it does not in {}; the exact condition "
          "(directions that no noise touches must fix the unobservable ones) errs in {}",
          c.cells, c.paper_wrong, c.paper_too_strict, c.exact_wrong),
      .long_run =
          "measured over 2^21 steps by doubling; (22) holds where the range of ΔP contains that of the "
          "process noise, and is one rank of vehicle noise too generous elsewhere",
      .verdict = paper_right ? ClaimVerdict::holds : ClaimVerdict::fails};
}

Claim anchored_is_bounded() {
  const LinearModel model = monobot(1, 1);
  const auto steps = linear_filter_steps(model, kFull, kLong);
  LinearModel other = model;
  other.P0 *= 100.0;
  const Matrix P = steps.back().P;
  const Matrix from_other = linear_filter_steps(other, kFull, kLong).back().P;
  const Matrix partial = linear_filter_steps(monobot(1), kFull, kMonobotSteps).back().P;
  const double difference = (P - from_other).norm() / P.norm();
  const double at_100 = steps[kMonobotSteps - 1].P.trace();
  return {.id = "anchored-bounded",
          .source = "Figure 4",
          .statement =
              "with one landmark as anchor full decorrelation stays bounded, variances are lower, and the "
              "limit does not depend on P0",
          .measured = fmt::format("posterior trace {:.6f} m² at step {} ({:.6f} m² without anchor)", at_100,
                                  kMonobotSteps, partial.trace()),
          .long_run = fmt::format("{:.6f} m² at step {}; from 100 times the P0 it differs by {} of its norm",
                                  P.trace(), kLong, number_text(difference, 1)),
          .verdict = holds_if(std::abs(P.trace() / at_100 - 1.0) < 1e-6 && difference < 1e-9 &&
                              P.trace() < partial.trace())};
}

}  // namespace

std::string_view to_string(ClaimVerdict verdict) {
  return word_of(verdict, {"holds", "conditional", "fails", "not measured"});
}

std::vector<Claim> monobot_claims() {
  return {unit_eigenvalue(),    error_of_one_run(), limit_depends_on_initial(), controllability_rank(),
          observability_rank(), gains_die_out(),    full_is_unbounded(),        map_is_bounded(),
          one_landmark_map(),   larger_variance(),  rank_condition(),           anchored_is_bounded()};
}

}  // namespace credence::internal
