#include "analysis/stability/stability_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "analysis/stability/boundedness.h"
#include "analysis/stability/unobservable_names.h"
#include "core/filters/linear_filter.h"
#include "core/nan.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// Increments below this share of the trace are rounding.
constexpr double kGrowthTolerance = 1e-6;

/// Where P grows without bound without any inflation, the reason.
std::string cause_of_growth(const LinearModel& model) {
  const ExactBoundedness exact = exact_boundedness(model.F, model.H, model.G * model.Q * model.G.transpose());
  switch (exact.reason) {
    case BoundednessReason::unstable: return "; P grows without bound: an unobservable direction is unstable";
    case BoundednessReason::unpaired:
      return "; P grows without bound: noise, or a direction that stays, drives an unobservable one";
    default: return {};
  }
}

/// What became of step `number`, which is not ok, in words.
std::string failure_of(const LinearFilterStep& step, Index number, const LinearModel& model) {
  const bool overflowed =
      !step.P_prior.allFinite() || !step.S.allFinite() || (step.P.size() > 0 && !step.P.allFinite());
  return fmt::format("{} at step {}{}",
                     overflowed ? "P leaves the range of double" : "S is not positive definite", number,
                     cause_of_growth(model));
}

/// Follows the filter; `last` receives the step `steps`, or the last that succeeds, and `steps` its number.
LongHorizon follow(const LinearModel& model, const InflationRule& rule, Index& steps, Index horizon,
                   LinearFilterStep& last) {
  LongHorizon h;
  const Index asked = std::exchange(steps, 0);
  LinearFilter filter(model, rule);
  for (Index done = 0; done < horizon;) {
    stop_point();
    const LinearFilterStep& step = filter.step();
    if (!step.ok) {
      h.failure = failure_of(step, done + 1, model);
      h.growth = judge_growth(h.trace_prior, kGrowthTolerance);
      h.growth.verdict = LongRun::failed;
      return h;
    }
    h.trace_prior.push_back(step.P_prior.trace());
    h.trace.push_back(step.P.trace());
    h.converged = h.converged && step.converged;
    if (++done <= asked) last = step, steps = done;
  }
  h.growth = judge_growth(h.trace_prior, kGrowthTolerance);
  return h;
}

/// Another initial covariance: larger, and differently so for every state.
Matrix other_initial(const Matrix& P0) {
  const Index n = P0.rows();
  const double largest = P0.diagonal().maxCoeff(), size = largest > 0.0 ? largest : 1.0;
  return 3.0 * P0 + Matrix(Vector::LinSpaced(n, size, 2.0 * size).asDiagonal());
}

/// Of a first prior that no number holds.
RiccatiSolution no_solution(const RiccatiProblem& problem) {
  RiccatiSolution none;
  none.reason = "the first prior leaves the range of double";
  none.P = Matrix::Constant(problem.state_dim(), problem.state_dim(), kNaN);
  none.K = Matrix::Constant(problem.state_dim(), problem.H.rows(), kNaN);
  none.residual = none.growth_exponent = none.spectral_radius = kNaN;
  return none;
}

void compare_initial_covariances(StabilityAnalysis& a, const RiccatiProblem& problem, const Matrix& P0) {
  // A filter predicts before it measures: its first prior.
  const auto limit_from = [&problem](const Matrix& P) {
    const Matrix prior = problem.F * P * problem.F.transpose() + problem.Qt;
    return prior.allFinite() ? solve_riccati(problem, prior) : no_solution(problem);
  };
  a.riccati = limit_from(P0);
  a.riccati_other = limit_from(other_initial(P0));
  a.initial_covariance_effect = kNaN;
  if (!a.riccati.has_limit() || !a.riccati_other.has_limit()) return;
  const double size = std::max(a.riccati.P.norm(), a.riccati_other.P.norm());
  a.initial_covariance_effect = size > 0.0 ? (a.riccati.P - a.riccati_other.P).norm() / size : 0.0;
  a.depends_on_initial = a.initial_covariance_effect > kInitialEffectTolerance;
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

StabilityAnalysis analyse_stability(const LinearModel& assumed, const InflationRule& rule, Index steps,
                                    Index horizon, const std::vector<std::string>& states) {
  const auto name = [&](const Matrix& directions) {
    return states.empty() ? name_unobservable(directions, assumed.layout)
                          : name_unobservable(directions, states);
  };
  if (steps < 1) throw std::invalid_argument(fmt::format("steps = {}: must be at least 1", steps));
  if (horizon < std::max<Index>(4, steps)) {
    throw std::invalid_argument(
        fmt::format("horizon = {}: must be at least {}", horizon, std::max<Index>(4, steps)));
  }
  StabilityAnalysis a;
  a.state_dim = assumed.state_dim();
  a.steps = steps;
  a.in_metres = states.empty();
  a.sequential = rule.is_sequential();
  a.inflation_varies = rule.inflation != Inflation::none;

  const Index n = assumed.state_dim();
  LinearFilterStep last;
  last.K = Matrix::Constant(n, assumed.measurement_dim(), kNaN);
  last.inflation = Matrix::Zero(n, n);
  a.long_horizon = follow(assumed, rule, a.steps, horizon, last);
  const Matrix GQG = assumed.G * assumed.Q * assumed.G.transpose();
  const RiccatiProblem problem{assumed.F, assumed.H, GQG + last.inflation, assumed.R};
  require_valid(problem, assumed.P0);

  const ObservabilityAnalysis seen = observability(assumed.F, assumed.H);
  a.controllability = controllability(assumed.F, assumed.G, assumed.Q).decision;
  a.observability = seen.decision;
  a.inflation = psd_rank(last.inflation);
  a.noise_total = psd_rank(problem.Qt);
  for (const NamedDirection& d : name(seen.unobservable)) a.unobservable.push_back(d.name);

  a.K = last.K;
  if (a.steps > 0) a.closed_loop_eigenvalues = closed_loop_eigenvalues(assumed.F, a.K, assumed.H);
  a.spectral_radius = a.closed_loop_eigenvalues.size() > 0 ? std::abs(a.closed_loop_eigenvalues[0]) : kNaN;
  compare_initial_covariances(a, problem, assumed.P0);

  const ExactBoundedness exact = exact_boundedness(assumed.F, assumed.H, problem.Qt);
  a.predicted_bounded = exact.bounded();
  a.prediction_reason = to_string(exact.reason);
  if (problem.F.isIdentity(0.0)) {
    a.noise_condition = noise_condition(problem, assumed.P0);
    const Matrix& u = a.noise_condition->direction;
    if (u.size() > 0) a.growth_direction = name(u).front().name;
  }
  a.paper_condition_holds = paper_boundedness(last.inflation, a.observability.rank).bounded();
  return a;
}

}  // namespace credence
