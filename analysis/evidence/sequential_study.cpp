#include "analysis/evidence/sequential_study.h"

#include <vector>

namespace credence {
namespace {

StopRule rule_of(const Scenario& scenario) {
  const StopSettings& stop = scenario.stop;
  return {.confidence = scenario.study.confidence,
          .on_verdict = stop.verdict != StopVerdict::none,
          .consistent_within = stop.verdict == StopVerdict::either ? stop.consistent_within : 0.0,
          .precision = stop.precision};
}

/// Mean NEES over the runs and steps of a chunk.
Moments average_of(const StudyStatistics& chunk) {
  Moments all;
  for (const StepStatistics& step : chunk.steps) all.merge(step[Quantity::nees]);
  return all;
}

}  // namespace

SequentialStudy::SequentialStudy(const Scenario& scenario)
    : rule_(rule_of(scenario)), most_runs_(scenario.most_runs()) {}

bool SequentialStudy::look(const StudyStatistics& chunk, const StudyStatistics& prefix) {
  if (chunk.runs == kChunkRuns) {
    if (const Moments average = average_of(chunk); average.count > 0) chunk_averages_.add(average.mean);
  }
  const std::vector<Moments> nees = prefix.series(Quantity::nees), nis = prefix.series(Quantity::nis);
  const std::vector<double> nees_dof = prefix.dofs(Quantity::nees);
  const std::vector<double> nis_dof = prefix.dofs(Quantity::nis);
  decision_ = credence::look(rule_, {.nees = nees,
                                     .nees_dof = nees_dof,
                                     .nis = nis,
                                     .nis_dof = nis_dof,
                                     .run_average_nees = chunk_averages_,
                                     .last = prefix.runs == most_runs_});
  return decision_.stop;
}

}  // namespace credence
