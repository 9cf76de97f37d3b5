#include "montecarlo/worlds/slam_settings.h"

#include <fmt/format.h>

#include "core/append_item.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/estimator_key.h"

namespace credence::internal {
namespace {

constexpr std::string_view kOnlyRank = "with filter.inflation = \"rank\"";

bool is_anchored(const Scenario& s) { return s.world.observability == Observability::full; }
bool is_of_rank(const Scenario& s) { return s.filter.inflation == FilterInflation::rank; }
bool is_decorrelating(const Scenario& s) {
  return s.filter.inflation == FilterInflation::full || s.filter.inflation == FilterInflation::map;
}

/// rank G: the noises of the vehicle, one on a line and two in the plane.
Index vehicle_noises(const BlockLayout& layout) { return layout.vehicle == 1 ? 1 : 2; }

constexpr auto kFilter = &Scenario::filter;

}  // namespace

KeyRow process_scale_key() {
  return {"filter", "process_scale", "", "process variance the filter assumes, over the true one",
          real_field<kFilter, &FilterSettings::process_scale>(Interval::kPositive)};
}

KeyRow measurement_scale_key() {
  return {"filter", "measurement_scale", "", "measurement variance the filter assumes, over the true one",
          real_field<kFilter, &FilterSettings::measurement_scale>(Interval::kPositive)};
}

std::vector<KeyRow> slam_keys() {
  using W = WorldSettings;
  using F = FilterSettings;
  constexpr auto kWorld = &Scenario::world;
  return {
      {"world", "landmarks", "", "landmarks that are states; 0 only with anchors",
       integer_field<kWorld, &W::landmarks>(0, 1'000'000)},
      {"world", "observability", "",
       "partial: all landmarks are states; full: `anchors` more stand at known positions",
       choice_field<kWorld, &W::observability>(Observability::full)},
      {.section = "world",
       .name = "anchors",
       .unit = "",
       .meaning =
           "known landmarks that are no states; of no effect with observability = \"partial\"; the plane "
           "needs 2 to be fully observable",
       .field = integer_field<kWorld, &W::anchors>(0, 1'000'000),
       .in_effect = is_anchored},
      {"filter", "inflation", "",
       "what is decorrelated: nothing, vehicle and map, the map only; rank: a constant covariance is added",
       choice_field<kFilter, &F::inflation>(FilterInflation::rank)},
      {.section = "filter",
       .name = "solution",
       .unit = "",
       .meaning =
           "bound that decorrelates: sum over pairs, exact least trace, exact after each scalar measurement "
           "(map only, O(N)), after each batch of them (the same), or without any gain for the map; of no "
           "effect with inflation = \"none\" or \"rank\"",
       .field = choice_field<kFilter, &F::solution>(InflationSolution::drop),
       .in_effect = is_decorrelating},
      process_scale_key(),
      measurement_scale_key(),
      {"filter", "inflation_rank", "", "rank of the constant added covariance",
       integer_field<kFilter, &F::inflation_rank>(0, 3'000'000), is_of_rank, kOnlyRank},
      {"filter", "inflation_range", "",
       "where the range of the constant added covariance lies: anywhere, in the landmarks, containing the "
       "vehicle's own noise, in the differences of landmarks",
       choice_field<kFilter, &F::inflation_range>(InflationRange::difference), is_of_rank, kOnlyRank},
      {"filter", "inflation_scale", "m^2", "every non-zero eigenvalue of the constant added covariance",
       real_field<kFilter, &F::inflation_scale>(Interval::kPositive), is_of_rank, kOnlyRank},
  };
}

void check_landmarks(const Scenario& scenario, const Refusal& refuse) {
  const WorldSettings& world = scenario.world;
  if (world.observability == Observability::partial) {
    if (world.landmarks < 1) {
      refuse.impossible("world", "landmarks", "must be >= 1 with world.observability = \"partial\"");
    }
  } else if (world.anchors < 1) {
    refuse.impossible("world", "anchors", "must be >= 1 with world.observability = \"full\"");
  }
}

void check_sensor_range(const Scenario& scenario, const Refusal& refuse) {
  const WorldSettings& world = scenario.world;
  if (world.sensor_min_range < world.sensor_range) return;
  refuse.impossible("world", "sensor_min_range",
                    fmt::format("must be < world.sensor_range = {}", world.sensor_range));
}

void check_inflation(const Scenario& scenario, const Refusal& refuse) {
  const FilterSettings& filter = scenario.filter;
  if (filter.inflation == FilterInflation::full && map_bound(filter.solution).has_value()) {
    refuse.impossible("filter", "solution",
                      "needs filter.inflation = \"map\", it is \"full\"; with \"full\" accepted are "
                      "\"pairwise\", \"min-trace\"");
  }
  if (filter.inflation != FilterInflation::rank) return;
  const BlockLayout layout = block_layout(scenario);
  const Index most = max_inflation_rank(layout, filter.inflation_range);
  const Index least = filter.inflation_range == InflationRange::with_vehicle ? vehicle_noises(layout) : 0;
  if (filter.inflation_rank < least || filter.inflation_rank > most) {
    refuse.impossible(
        "filter", "inflation_rank",
        fmt::format("must be from {} to {} with world.landmarks = {} and filter.inflation_range = \"{}\"",
                    least, most, scenario.world.landmarks, to_string(filter.inflation_range)));
  }
}

void check_contested_slam(const Scenario& scenario, const Refusal& refuse, const EstimatorOffer& offer) {
  check_estimator(scenario, refuse, offer);
  if (scenario.world.landmarks < 1) refuse.impossible("world", "landmarks", "must be >= 1");
  check_sensor_range(scenario, refuse);
}

BlockLayout plane_slam_blocks(const Scenario& scenario) {
  return {.vehicle = 3, .landmark = 2, .landmarks = scenario.world.landmarks};
}

InflationRule make_inflation_rule(const Scenario& scenario) {
  const FilterSettings& f = scenario.filter;
  InflationRule rule;
  rule.solution = f.solution;
  switch (f.inflation) {
    case FilterInflation::none: break;
    case FilterInflation::full: rule.inflation = Inflation::full; break;
    case FilterInflation::map: rule.inflation = Inflation::map; break;
    case FilterInflation::rank: {
      const BlockLayout layout = block_layout(scenario);
      const Matrix G = Matrix::Identity(layout.state_dim(), vehicle_noises(layout));
      rule.constant = rank_inflation(layout, G,
                                     {.rank = f.inflation_rank,
                                      .range = f.inflation_range,
                                      .scale = f.inflation_scale,
                                      .seed = scenario.study.seed});
      break;
    }
  }
  return rule;
}

std::string slam_text(const Scenario& scenario) {
  const WorldSettings& world = scenario.world;
  const std::string anchors = world.anchors == 0 ? "partially observable" : counted(world.anchors, "anchor");
  const double seen = scenario.noise.detection_probability;
  return fmt::format("{}, {}, {}{}{}", world.model, counted(world.landmarks, "landmark"), anchors,
                     seen < 1.0 ? fmt::format(", each measured with probability {:g}", seen) : "",
                     noise_switches_text(scenario));
}

std::string slam_size_text(const Scenario& scenario) {
  return fmt::format("world.landmarks = {}, world.anchors = {}", scenario.world.landmarks,
                     scenario.world.anchors);
}

std::string landmarks_size_text(const Scenario& scenario) {
  return fmt::format("world.landmarks = {}", scenario.world.landmarks);
}

}  // namespace credence::internal
