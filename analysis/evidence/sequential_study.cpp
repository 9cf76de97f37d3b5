#include "analysis/evidence/sequential_study.h"

#include <vector>

namespace credence::internal {
namespace {

StopRule rule_of(const Scenario& scenario) {
  const StopSettings& stop = scenario.stop;
  return {.confidence = scenario.study.confidence,
          .on_verdict = stop.verdict != StopVerdict::none,
          .consistent_within = stop.verdict == StopVerdict::either ? stop.consistent_within : 0.0,
          .precision = stop.precision};
}

}  // namespace

SequentialStudy::SequentialStudy(const Scenario& scenario)
    : rule_(rule_of(scenario)), most_runs_(scenario.most_runs()) {}

bool SequentialStudy::look(const StudyStatistics& chunk, const StudyStatistics& prefix) {
  const RunAverages& runs = chunk.nees_of_runs;
  if (!runs.first.empty()) {
    const BettingPrices prices = betting_prices(static_cast<double>(runs.least_dof));
    for (const double average : runs.first) betting_.add(average, prices);
  }
  const std::vector<Moments> nees = prefix.series(Quantity::nees), nis = prefix.series(Quantity::nis);
  const std::vector<double> nees_dof = prefix.dofs(Quantity::nees);
  const std::vector<double> nis_dof = prefix.dofs(Quantity::nis);
  decision_ = credence::internal::look(rule_, {.nees = nees,
                                               .nees_dof = nees_dof,
                                               .nis = nis,
                                               .nis_dof = nis_dof,
                                               .runs = &prefix.nees_of_runs,
                                               .betting = &betting_,
                                               .last = prefix.runs == most_runs_});
  return decision_.stop;
}

}  // namespace credence::internal
