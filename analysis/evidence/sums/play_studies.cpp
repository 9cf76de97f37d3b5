#include "analysis/evidence/sums/play_studies.h"

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

std::vector<PlayedStudy> play_studies(std::span<const StudyToPlay> studies, const EngineOptions& options) {
  std::vector<StudyTask> tasks;
  std::vector<SequentialStudy> watches;
  watches.reserve(studies.size());
  for (const StudyToPlay& study : studies) {
    const Scenario& scenario = *study.scenario;
    StudyTask& task = tasks.emplace_back(
        StudyTask{.id = study.id, .experiment = study.experiment, .runs = scenario.most_runs()});
    task.max_seconds = scenario.stop.max_seconds;
    task.steps = scenario.study.steps;
    if (study.evidence != nullptr) study.evidence->keep_with(task);
    SequentialStudy& watch = watches.emplace_back(scenario);
    if (!scenario.stop.asked()) continue;
    task.enough = [&watch](const StudyStatistics& chunk, const StudyStatistics& prefix) {
      return watch.look(chunk, prefix);
    };
  }
  std::vector<StudyResult> results = run_studies(tasks, options);
  std::vector<PlayedStudy> played;
  for (std::size_t i = 0; i < results.size(); ++i) {
    played.push_back({std::move(results[i]), std::nullopt});
    if (studies[i].scenario->stop.asked()) played.back().stop = watches[i].decision();
  }
  return played;
}

}  // namespace credence::internal
