#include "analysis/studies/estimator_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "montecarlo/engine/ranks.h"

namespace credence::internal {

Verdict EstimatorMap::verdict(std::size_t point, std::size_t e) const {
  const EstimatorRow& row = studies[point].rows[e];
  const DirectedPValues& p = row.beyond_tolerance;
  if (std::isnan(p.optimistic)) return Verdict::undecided;
  const double level = 1.0 - studies[point].scenario.study.confidence;
  const Verdict seen = direction_of(2.0 * p.optimistic <= level, 2.0 * p.pessimistic <= level);
  const MeanInterval& nees = row.nees[static_cast<std::size_t>(EstimatorBlock::pose)];
  return seen == Verdict::consistent && is_undecided(nees) ? Verdict::undecided : seen;
}

bool EstimatorMap::stays_consistent(std::size_t point, std::size_t e) const {
  return studies[point].rows[e].failures.empty() && verdict(point, e) == Verdict::consistent;
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

namespace {

/// What is asked for, or of all what takes every point; the others go into `left_out`, each once.
std::vector<std::string> names_of_all_points(const SweepPlan& plan, const std::vector<std::string>& asked,
                                             std::vector<LeftOutEstimator>& left_out) {
  std::vector<std::string> names = asked;
  for (const SweepPoint& point : plan.points) {
    ChosenEstimators chosen = choose_estimators(point.scenario, asked);
    if (!asked.empty()) continue;
    for (LeftOutEstimator& of : chosen.left_out) {
      if (std::ranges::find(left_out, of.name, &LeftOutEstimator::name) == left_out.end())
        left_out.push_back(std::move(of));
    }
    for (std::string& name : chosen.names) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
    }
  }
  std::erase_if(names, [&](const std::string& name) {
    return std::ranges::find(left_out, name, &LeftOutEstimator::name) != left_out.end();
  });
  if (names.empty()) throw std::invalid_argument(left_out.front().reason);
  return names;
}

}  // namespace

EstimatorMap map_estimators(const SweepPlan& plan, const EstimatorStudyOptions& options) {
  EstimatorMap map;
  map.plan = plan;
  const std::vector<std::string> names = names_of_all_points(plan, options.estimators, map.left_out);
  std::int64_t total = 0, before = 0;
  for (const SweepPoint& point : plan.points) total += point.scenario.study.runs;
  for (const SweepPoint& point : plan.points) {
    EstimatorStudyOptions of_point = options;
    of_point.estimators = names;
    of_point.progress = [&](const StudyProgress& of_it) {
      StudyProgress progress = of_it;
      progress.runs_done += before;
      progress.runs_total = total;
      if (options.progress) options.progress(progress);
    };
    map.studies.push_back(study_estimators(point.scenario, of_point));
    map.complete = map.studies.back().complete;
    const bool stopped = options.stop != nullptr && options.stop->load();
    // A helper's studies are never complete; it is told otherwise when there is no more to do.
    if (!map.complete && (stopped || !is_helper(options.ranks))) return map;
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

}  // namespace credence::internal
