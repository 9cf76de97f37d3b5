#include "analysis/evidence/verdicts/series_verdicts.h"

#include <algorithm>
#include <string>
#include <utility>

#include "analysis/evidence/verdicts/consistency_judge.h"
#include "analysis/laws/mean/run_mean.h"

namespace credence::internal {
namespace {

/// A sum over parts whose covariances are not known, blocks or sensors: each step, too, is a sum of dependent
/// χ². Their dof are taken as equal, which is the widest as the spread of χ²(n) grows like √n.
VerdictLaws separate_laws(std::size_t blocks, std::string method) {
  const double parts = static_cast<double>(blocks);
  VerdictLaws laws;
  laws.step = [=](double dof, double) { return dependent_law(std::vector<double>(blocks, dof / parts)); };
  laws.overall = [=](const std::vector<StepTest>& tested) {
    std::vector<double> dofs;
    for (const StepTest& step : tested) dofs.insert(dofs.end(), blocks, step.total_dof / parts);
    return dependent_law(dofs);
  };
  laws.method = std::move(method);
  return laws;
}

}  // namespace

StepSeries series_of(const SumsOverSteps& sums, std::size_t steps) {
  StepSeries series;
  series.moments.resize(std::max(steps, sums.size()));
  series.dof.resize(series.moments.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    series.moments[k] = sums[k].value;
    series.dof[k] = static_cast<double>(sums[k].dof);
  }
  return series;
}

ConsistencyVerdict judge_state(const Evidence& e, const StepSeries& series, double confidence,
                               const RunAverages* runs) {
  if (e.joint_covariance || e.blocks.size() < 2)
    return judge_nees(series.moments, series.dof, confidence, runs);
  VerdictLaws laws = separate_laws(
      e.blocks.size(),
      "NEES summed over blocks whose covariances are not in the log; every step and the sum over steps by a "
      "bound for every dependence, Bonferroni over the steps");
  if (runs != nullptr && runs->moments.count >= kFewestRunsCompared) laws.runs = runs;
  return judge_sums(series.moments, series.dof, confidence, laws);
}

ConsistencyVerdict judge_all_sensors(const Evidence& e, const StepSeries& nis, double confidence) {
  if (e.sensors.size() < 2) return judge_nis(nis.moments, nis.dof, confidence);
  return judge_sums(nis.moments, nis.dof, confidence,
                    separate_laws(e.sensors.size(),
                                  "NIS summed over sensors that may share the error of a prior; every step "
                                  "and the sum over steps by a bound for every dependence, Bonferroni over "
                                  "the steps"));
}

}  // namespace credence::internal
