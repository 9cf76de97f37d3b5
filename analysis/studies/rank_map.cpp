#include "analysis/studies/rank_map.h"

#include <algorithm>
#include <map>
#include <utility>

#include "analysis/laws/joint/multiple_tests.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

double error_growth_of(const std::vector<ExactMoments>& exact) {
  if (exact.size() < 2) return 1.0;
  const double half = exact[exact.size() / 2 - 1].Sigma.trace();
  return half > 0.0 ? exact.back().Sigma.trace() / half : 1.0;
}

}  // namespace

bool is_rank_map_cell(const Scenario& scenario) {
  return scenario.world.model == "monobot" && scenario.filter.inflation == FilterInflation::rank &&
         scenario.noise.detection_probability == 1.0;
}

RankMapCell rank_map_cell(const StudyAnalysis& analysis) {
  const Scenario& scenario = analysis.scenario;
  const LinearProblem cell_problem = linear_problem(scenario).value();
  const LinearModel& model = cell_problem.assumed;
  const Matrix& inflation = cell_problem.rule.constant;
  const RiccatiProblem problem{model.F, model.H, model.G * model.Q * model.G.transpose() + inflation,
                               model.R};
  const ExactBoundedness exact = exact_boundedness(problem.F, problem.H, problem.Qt);
  const MeasuredBoundedness measured = measure_boundedness(problem, model.P0);
  const PaperBoundedness paper = paper_boundedness(inflation, exact.observability.rank);

  RankMapCell cell;
  cell.observability = scenario.world.observability;
  cell.range = scenario.filter.inflation_range;
  cell.landmarks = scenario.world.landmarks;
  cell.state_dim = model.state_dim();
  cell.inflation_rank = paper.inflation_rank;
  cell.observability_rank = paper.observability_rank;
  cell.bounded = measured.bounded;
  cell.growth_exponent = measured.growth_exponent;
  cell.growth_per_step = measured.bounded ? 0.0 : measured.trace_per_step;
  cell.predicted = exact.bounded();
  cell.paper = paper.bounded();
  cell.nees_ratio = analysis.nees.mean / analysis.nees.expected;
  cell.nees_p_value = analysis.nees.p_value;
  cell.error_growth = error_growth_of(analysis.exact);
  return cell;
}

std::vector<RankMapSummary> summarise(std::span<const RankMapCell> cells, double confidence) {
  std::vector<double> p_values;
  for (const RankMapCell& cell : cells) p_values.push_back(cell.nees_p_value);
  const std::vector<double> adjusted = holm(p_values);
  std::map<std::pair<Observability, InflationRange>, RankMapSummary> groups;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const RankMapCell& cell = cells[i];
    RankMapSummary& group = groups[{cell.observability, cell.range}];
    group.observability = cell.observability;
    group.range = cell.range;
    ++group.cells;
    group.bounded += cell.bounded ? 1 : 0;
    group.exact_errs += cell.predicted != cell.bounded ? 1 : 0;
    group.paper_errs += cell.paper != cell.bounded ? 1 : 0;
    group.errors_outside += cell.nees_ratio > 1.0 && adjusted[i] <= 1.0 - confidence ? 1 : 0;
    group.largest_nees_ratio = std::max(group.largest_nees_ratio, cell.nees_ratio);
  }
  std::vector<RankMapSummary> result;
  result.reserve(groups.size());
  for (const auto& [key, group] : groups) result.push_back(group);
  return result;
}

}  // namespace credence::internal
