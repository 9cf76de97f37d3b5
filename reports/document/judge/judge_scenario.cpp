#include "reports/document/judge/judge_scenario.h"

#include <memory>
#include <stdexcept>
#include <utility>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/play_studies.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/judge/judged.h"

namespace credence::internal {

JudgedFilter judge_study(const Scenario& scenario, const EngineOptions& runs, const EngineOptions& further) {
  const std::unique_ptr<const Experiment> experiment = make_experiment(scenario);
  EvidenceCollector evidence(*experiment, evidence_runs(scenario, scenario.most_runs()));
  const StudyToPlay study{configuration_id(scenario), &scenario, experiment.get(), &evidence};
  PlayedStudy played = std::move(play_studies({&study, 1}, runs).front());
  if (played.result.statistics.runs == 0) {
    throw std::runtime_error("interrupted before the first runs were done");
  }
  StudyAnalysis analysis = analyse_study(scenario, *experiment, std::move(played.result), played.stop);
  add_judgement(analysis, evidence, further);
  add_posterior_bound(analysis, further);
  return JudgedFilter(judged_study({std::move(analysis), experiment->trace(0)}));
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

JudgedFilter judge_scenario(const Scenario& scenario, const PlayOptions& options) {
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = options.stop;
  return judge_study(scenario, engine, engine);
}

}  // namespace credence
