#include "montecarlo/worlds/filter_setup.h"

namespace credence {

InflationRule make_inflation_rule(const Scenario& scenario) {
  const FilterSettings& f = scenario.filter;
  InflationRule rule;
  rule.solution = f.solution;
  switch (f.inflation) {
    case FilterInflation::none:
      break;
    case FilterInflation::full:
      rule.inflation = Inflation::full;
      break;
    case FilterInflation::map:
      rule.inflation = Inflation::map;
      break;
    case FilterInflation::rank: {
      const BlockLayout layout = block_layout(scenario);
      const Matrix G = Matrix::Identity(layout.state_dim(), layout.vehicle == 1 ? 1 : 2);
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

LinearModel make_true_model(const Scenario& scenario) {
  return monobot_model(scenario.world.landmarks, scenario.world.anchors, scenario.noise.process_variance,
                       scenario.noise.measurement_variance, scenario.noise.initial_variance);
}

LinearModel make_assumed_model(const Scenario& scenario) {
  LinearModel model = make_true_model(scenario);
  model.Q *= scenario.filter.process_scale;
  model.R *= scenario.filter.measurement_scale;
  return model;
}

}  // namespace credence
