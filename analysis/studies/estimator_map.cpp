#include "analysis/studies/estimator_map.h"

#include <algorithm>
#include <limits>

namespace credence {

bool EstimatorMap::stays_consistent(std::size_t point, std::size_t e) const {
  const EstimatorRow& row = studies[point].rows[e];
  const MeanInterval& nees = row.nees[static_cast<std::size_t>(EstimatorBlock::pose)];
  return row.failures.empty() && nees.lower <= kToleratedOptimism;
}

std::optional<std::size_t> EstimatorMap::cheapest(std::size_t point) const {
  const auto is_asked = [&](std::size_t e) { return names[e] != "ideal" && stays_consistent(point, e); };
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < names.size(); ++e) {
    if (is_asked(e)) least = std::min(least, seconds_per_step[e]);
  }
  for (std::size_t e = 0; e < names.size(); ++e) {
    if (is_asked(e) && seconds_per_step[e] <= kSameCost * least) return e;
  }
  return std::nullopt;
}

EstimatorMap map_estimators(const SweepPlan& plan, const EstimatorStudyOptions& options) {
  EstimatorMap map;
  map.plan = plan;
  std::int64_t total = 0, before = 0;
  for (const SweepPoint& point : plan.points) total += point.scenario.study.runs;
  for (const SweepPoint& point : plan.points) {
    EstimatorStudyOptions of_point = options;
    of_point.progress = [&](std::int64_t done, std::int64_t) {
      if (options.progress) options.progress(before + done, total);
    };
    map.studies.push_back(study_estimators(point.scenario, of_point));
    map.complete = map.studies.back().complete;
    if (!map.complete) return map;
    before += point.scenario.study.runs;
  }
  for (const EstimatorRow& row : map.studies.front().rows) map.names.push_back(row.name);
  map.seconds_per_step.assign(map.names.size(), 0.0);
  for (const EstimatorStudy& study : map.studies) {
    for (std::size_t e = 0; e < map.names.size(); ++e) {
      map.seconds_per_step[e] +=
          study.rows[e].profile.seconds_per_step / static_cast<double>(map.studies.size());
    }
  }
  return map;
}

}  // namespace credence
