#include "analysis/evidence/play_studies.h"

#include "analysis/evidence/sequential_study.h"

namespace credence::internal {

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
