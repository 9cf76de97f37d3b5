#include "analysis/stability/planar_stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/stability/planar_path.h"
#include "analysis/stability/riccati.h"
#include "analysis/stability/unobservable_names.h"
#include "core/inflation/inflation_rule.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Above the accuracy of an exact minimal trace, whose error would else fill the kernel of the noise.
constexpr double kAccumulatedTolerance = 1e-6;

Matrix anchor_positions(const PlanarWorld& world) {
  Matrix positions(2, world.anchors);
  for (Index i = 0; i < world.anchors; ++i) {
    positions.col(i) = world.landmarks[static_cast<std::size_t>(world.states() + i)];
  }
  return positions;
}

PlanarRanks ranks_of(const PlanarLoopRecord& loop, const PlanarWorld& world) {
  PlanarRanks ranks{local_observability(loop.F, loop.H), {}};
  for (const NamedDirection& d : name_unobservable(ranks.observability.unobservable, loop.layout, loop.start,
                                                   anchor_positions(world))) {
    ranks.unobservable.push_back(d.name);
  }
  return ranks;
}

ExactBoundedness accumulated(const PlanarLoopRecord& loop, const ObservabilityAnalysis& observability) {
  AccumulatedNoise noise(loop.layout.state_dim());
  for (std::size_t k = 0; k < loop.F.size(); ++k) noise.add(loop.F[k], loop.process[k] + loop.inflation[k]);
  return exact_boundedness(noise, observability, kAccumulatedTolerance);
}

/// Transition of the filter's error over the loop.
Eigen::VectorXcd loop_eigenvalues(const PlanarLoopRecord& loop) {
  const Index n = loop.layout.state_dim();
  Matrix Psi = Matrix::Identity(n, n);
  for (std::size_t k = 0; k < loop.F.size(); ++k) {
    Psi = (loop.F[k] * Psi).eval();
    Psi -= (loop.K[k] * (loop.H[k + 1] * Psi)).eval();
  }
  return closed_loop_eigenvalues(Psi, Matrix(n, 0), Matrix(0, n));
}

PlanarFollowed followed(const PlanarPathRun& run, Linearisation at, InflationSolution solution,
                        const PlanarRanks& ranks) {
  PlanarFollowed f;
  f.at = at;
  f.solution = solution;
  f.traces = run.traces;
  f.growth = judge_growth(run.traces, kPlanarResolution);
  if (!run.ok) f.growth.verdict = LongRun::failed;
  f.failed_at = run.failed_at;
  f.not_converged = run.not_converged;
  f.pose_nees = run.pose_nees;
  f.spectral_radius = kNaN;
  if (run.loop.F.empty()) return f;
  f.inflation_rank = psd_rank(run.loop.inflation.back(), kAccumulatedTolerance).rank;
  if (!map_bound(solution).has_value()) f.exact = accumulated(run.loop, ranks.observability);
  f.closed_loop_eigenvalues = loop_eigenvalues(run.loop);
  if (f.closed_loop_eigenvalues.size() > 0) f.spectral_radius = std::abs(f.closed_loop_eigenvalues[0]);
  return f;
}

std::vector<InflationSolution> solutions_of(const Scenario& scenario, FollowedSolutions which) {
  using enum InflationSolution;
  if (which == FollowedSolutions::own) return {scenario.filter.solution};
  switch (scenario.filter.inflation) {
    case FilterInflation::map: return {pairwise, min_trace, sequential, batch, drop};
    case FilterInflation::full: return {pairwise, min_trace};
    default: return {scenario.filter.solution};
  }
}

Index process_rank_of(const PlanarLoopRecord& loop) {
  AccumulatedNoise noise(loop.layout.state_dim());
  for (std::size_t k = 0; k < loop.F.size(); ++k) noise.add(loop.F[k], loop.process[k]);
  return psd_rank(noise.S()).rank;
}

}  // namespace

std::string_view to_string(Linearisation at) { return at == Linearisation::truth ? "truth" : "estimate"; }

const PlanarFollowed& PlanarStability::own(InflationSolution solution, Linearisation at) const {
  const auto it = std::ranges::find_if(
      followed, [=](const PlanarFollowed& f) { return f.at == at && f.solution == solution; });
  if (it == followed.end()) {
    throw std::invalid_argument(
        fmt::format("no filter with filter.solution = \"{}\" was followed", to_string(solution)));
  }
  return *it;
}

PlanarStability analyse_planar_stability(const Scenario& scenario, Index loops, FollowedSolutions which) {
  if (loops < 4) throw std::invalid_argument(fmt::format("loops = {}: must be at least 4", loops));
  if (scenario.world.model != "planar" || scenario.filter.inflation == FilterInflation::rank) {
    throw std::invalid_argument("a planar world without a constant inflation is needed");
  }
  PlanarStability a;
  a.loops = loops;
  a.steps_per_loop = planar_steps_per_loop(scenario);
  for (const Linearisation at : {Linearisation::truth, Linearisation::estimate}) {
    PlanarRanks& ranks = at == Linearisation::truth ? a.truth : a.estimate;
    for (const InflationSolution solution : solutions_of(scenario, which)) {
      Scenario variant = scenario;
      variant.filter.solution = solution;
      const PlanarPathRun run = follow_planar_path(variant, loops, at);
      a.state_dim = 3 + 2 * run.world.states();
      if (ranks.observability.decision.singular_values.size() == 0 && !run.loop.F.empty()) {
        ranks = ranks_of(run.loop, run.world);
        a.process_rank = process_rank_of(run.loop);
      }
      PlanarFollowed f = followed(run, at, solution, ranks);
      if (at == Linearisation::truth && run.ok) {
        variant.initial.position_std *= 10.0;
        variant.initial.heading_std_deg *= 10.0;
        const PlanarPathRun other = follow_planar_path(variant, loops, at);
        if (other.ok) f.initial_effect = other.traces.back() / run.traces.back();
      }
      a.followed.push_back(std::move(f));
    }
  }
  return a;
}

}  // namespace credence::internal
