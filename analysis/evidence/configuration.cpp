#include "analysis/evidence/configuration.h"

#include <atomic>
#include <utility>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {

Configuration make_configuration(const Scenario& scenario) {
  return {.id = configuration_id(scenario), .scenario = scenario, .experiment = make_experiment(scenario)};
}

void take_evidence(Configuration& c) {
  const std::int64_t most = evidence_runs(c.scenario, c.scenario.most_runs());
  c.evidence = std::make_unique<EvidenceCollector>(*c.experiment, most);
}

std::vector<PlayedStudy> play(std::span<const Configuration> configurations, const EngineOptions& options) {
  std::vector<StudyToPlay> studies;
  for (const Configuration& c : configurations) {
    studies.push_back({c.id, &c.scenario, c.experiment.get(), c.evidence.get()});
  }
  return play_studies(studies, options);
}

std::vector<PlayedStudy> stored_results(std::span<const Configuration> configurations, ResultStore& store) {
  static constexpr std::atomic<bool> kNothingNew{true};
  return play(configurations, {.threads = 1, .stop = &kNothingNew, .store = &store});
}

StudyAnalysis analyse(const Configuration& configuration, PlayedStudy result) {
  return analyse_study(configuration.scenario, *configuration.experiment, std::move(result.result),
                       result.stop);
}

std::vector<StudyAnalysis> analyses_of(std::span<const Configuration> configurations,
                                       std::vector<PlayedStudy> results) {
  std::vector<StudyAnalysis> analyses;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].result.statistics.runs == 0) continue;
    analyses.push_back(analyse(configurations[i], std::move(results[i])));
  }
  return analyses;
}

void explain(StudyAnalysis& analysis, const Configuration& configuration, const EngineOptions& options) {
  if (configuration.evidence) {
    add_judgement(analysis, *configuration.evidence, options);
  } else {
    add_judgement(analysis, *configuration.experiment, options);
  }
  add_posterior_bound(analysis, options);
}

}  // namespace credence::internal
