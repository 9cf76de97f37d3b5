#include "analysis/evidence/sweep_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "analysis/laws/joint/multiple_tests.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {
namespace {

std::size_t point_of(const SweepPlan& plan, const StudyAnalysis& study) {
  const std::string id = configuration_id(study.scenario);
  const auto point = std::ranges::find(plan.points, id, &SweepPoint::id);
  if (point == plan.points.end()) {
    throw std::invalid_argument(fmt::format("configuration {} is no point of the sweep {}", id, plan.name));
  }
  return static_cast<std::size_t>(point - plan.points.begin());
}

bool is_rank_map(const SweepPlan& plan) {
  return std::ranges::all_of(plan.points, is_rank_map_cell, &SweepPoint::scenario);
}

}  // namespace

bool SweepAnalysis::stands(std::size_t study) const {
  return is_inconsistent(overall_verdict(studies[study])) &&
         p_values[study] <= 1.0 - studies[study].scenario.study.confidence;
}

std::vector<double> sweep_p_values(std::span<const StudyAnalysis> analyses) {
  std::vector<double> p_values;
  p_values.reserve(analyses.size());
  for (const StudyAnalysis& a : analyses) p_values.push_back(overall_p_value(a));
  return benjamini_yekutieli(p_values);
}

void forget_steps(StudyAnalysis& study) {
  study.statistics.steps = {};
  study.statistics.nees_of_runs = study.statistics.vehicle_nees_of_runs = {};
  for (ConsistencyVerdict* verdict : {&study.nees, &study.nis}) verdict->steps = {};
  if (study.vehicle_nees) study.vehicle_nees->steps = {};
  const std::vector<double>& trace = study.covariance.trace;
  CovarianceCurves last;
  if (!trace.empty()) last.trace = {trace.back()};
  study.covariance = std::move(last);
  study.errors = {};
  if (!is_rank_map_cell(study.scenario)) study.exact = {};
}

SweepAnalysis analyse_sweep(SweepPlan plan, std::vector<StudyAnalysis> studies) {
  SweepAnalysis sweep{std::move(plan), std::move(studies), {}, {}, {}};
  const bool map = is_rank_map(sweep.plan);
  for (const StudyAnalysis& study : sweep.studies) {
    sweep.points.push_back(point_of(sweep.plan, study));
    if (map) sweep.rank_map.push_back(rank_map_cell(study));
  }
  sweep.p_values = sweep_p_values(sweep.studies);
  return sweep;
}

}  // namespace credence::internal
