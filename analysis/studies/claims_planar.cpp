#include <fmt/format.h>

#include "analysis/stability/planar_stability.h"
#include "analysis/studies/claims.h"
#include "core/number_text.h"
#include "montecarlo/scenario/world_schema.h"

namespace credence::internal {
namespace {

Scenario circle(Index anchors, FilterInflation inflation) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 6;
  s.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  s.world.anchors = anchors;
  s.world.path = PathShape::circle;
  s.world.path_radius = 10.026761;  // 63 steps a round
  s.world.speed = 1.0;
  s.world.dt = 1.0;
  s.world.sensor_range = 12.0;
  s.noise.turn_rate_std = 0.02;
  s.filter.inflation = inflation;
  return s;
}

const PlanarFollowed& at_truth(const PlanarStability& a, InflationSolution solution) {
  return a.own(solution);
}

const PlanarFollowed& in_ekf(const PlanarStability& a, InflationSolution solution) {
  return a.own(solution, Linearisation::estimate);
}

std::string growth_text(const PlanarFollowed& f) {
  return fmt::format("{}, exponent {}", to_string(f.growth.verdict), fixed_text(f.growth.exponent, 2));
}

Index rank(const PlanarRanks& ranks) { return ranks.observability.decision.rank; }

Claim controllability_claim(const PlanarStability& free) {
  return {.id = "planar-controllability",
          .source = "section 4",
          .statement = "planar: the process noise moves the vehicle alone, rank C = 3 whatever the map",
          .measured = fmt::format("rank of the process noise accumulated over a loop: {} of {} states",
                                  free.process_rank, free.state_dim),
          .verdict = free.process_rank == 3 ? ClaimVerdict::holds : ClaimVerdict::fails};
}

Claim one_beacon_claim(const PlanarStability& free, const PlanarStability& one, const PlanarStability& two) {
  const bool fully = rank(one.truth) == one.state_dim;
  return {
      .id = "one-beacon",
      .source = "section 4, Figure 7",
      .statement = "planar: one landmark as anchor makes the filter fully observable",
      .measured = fmt::format("rank O with Jacobians at the truth: {} of {} without anchor, {} of {} with "
                              "one, {} of {} with two. One leaves the rotation about it free",
                              rank(free.truth), free.state_dim, rank(one.truth), one.state_dim,
                              rank(two.truth), two.state_dim),
      .long_run = fmt::format("at the EKF's own estimates {}, {} and {}: the extra rank is spurious "
                              "information; a hundredfold P0 multiplies the last trace by {} with one "
                              "anchor and by {} with two (map, exact minimal trace)",
                              rank(free.estimate), rank(one.estimate), rank(two.estimate),
                              number_text(at_truth(one, InflationSolution::min_trace).initial_effect, 3),
                              number_text(at_truth(two, InflationSolution::min_trace).initial_effect, 3)),
      .verdict = fully ? ClaimVerdict::holds : ClaimVerdict::fails};
}

Claim full_unbounded_claim(const PlanarStability& full) {
  const PlanarFollowed& pairwise = at_truth(full, InflationSolution::pairwise);
  const PlanarFollowed& exact = at_truth(full, InflationSolution::min_trace);
  const bool grows = pairwise.growth.verdict != LongRun::bounded && exact.growth.verdict != LongRun::bounded;
  return {.id = "planar-full-unbounded",
          .source = "Figure 5",
          .statement =
              "planar, partially observable, everything decorrelated: the covariance grows without bound",
          .measured = fmt::format("over {} loops: pairwise {}; exact minimal trace {}", full.loops,
                                  growth_text(pairwise), growth_text(exact)),
          .verdict = grows ? ClaimVerdict::holds : ClaimVerdict::fails};
}

Claim map_bounded_claim(const PlanarStability& map) {
  using enum InflationSolution;
  const bool exact_bounded = at_truth(map, min_trace).growth.verdict == LongRun::bounded;
  const bool pairwise_bounded = at_truth(map, pairwise).growth.verdict == LongRun::bounded;
  return {
      .id = "planar-map-bounded",
      .source = "Figure 6",
      .statement = "planar, partially observable, only the map decorrelated: the covariance stays bounded",
      .measured =
          fmt::format("over {} loops, Jacobians at the truth: pairwise {}; exact minimal trace {} ({} "
                      "steps above its duality gap); sequential {}",
                      map.loops, growth_text(at_truth(map, pairwise)), growth_text(at_truth(map, min_trace)),
                      at_truth(map, min_trace).not_converged, growth_text(at_truth(map, sequential))),
      .long_run =
          fmt::format("needs the exact minimal trace (or the sequential one); in the EKF: pairwise {}, "
                      "exact {}, whose pose NEES is {} times what it should be",
                      growth_text(in_ekf(map, pairwise)), growth_text(in_ekf(map, min_trace)),
                      number_text(in_ekf(map, min_trace).pose_nees, 3)),
      .verdict = !exact_bounded     ? ClaimVerdict::fails
                 : pairwise_bounded ? ClaimVerdict::holds
                                    : ClaimVerdict::conditional};
}

}  // namespace

std::vector<Claim> planar_claims(Index loops) {
  const PlanarStability free = analyse_planar_stability(circle(0, FilterInflation::map), loops);
  const PlanarStability one = analyse_planar_stability(circle(1, FilterInflation::map), loops);
  const PlanarStability two = analyse_planar_stability(circle(2, FilterInflation::map), loops);
  const PlanarStability full = analyse_planar_stability(circle(0, FilterInflation::full), loops);
  return {controllability_claim(free), one_beacon_claim(free, one, two), full_unbounded_claim(full),
          map_bounded_claim(free)};
}

}  // namespace credence::internal
