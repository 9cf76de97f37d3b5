#include "reports/document/judge/judge_scenario.h"

#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/judge/judged.h"

namespace credence::internal {

JudgedFilter judge_played(const Configuration& configuration, PlayedStudy played,
                          const EngineOptions& further) {
  if (played.result.statistics.runs == 0) {
    throw std::runtime_error("interrupted before the first runs were done");
  }
  StudyAnalysis analysis = analyse(configuration, std::move(played));
  explain(analysis, configuration, further);
  std::optional<RunTrace> trace = configuration.experiment->trace_to_draw(run_to_draw(analysis));
  return JudgedFilter(judged_study({std::move(analysis), std::move(trace)}));
}

EngineOptions engine_options(int threads, const std::atomic<bool>* stop, const JudgeProgress& progress) {
  EngineOptions options;
  options.threads = threads;
  options.stop = stop;
  if (progress) {
    options.progress = [progress](const StudyProgress& p) {
      progress(p.runs_stored + p.runs_done, p.runs_total);
    };
  }
  return options;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

JudgedFilter judge_scenario(const Scenario& scenario, const PlayOptions& options) {
  // A program may have set any field; what a file cannot say is refused as it would be there.
  load_scenario_text(canonical_toml(scenario), "the scenario");
  Configuration configuration = make_configuration(scenario);
  take_evidence(configuration);
  std::vector<PlayedStudy> played =
      play({&configuration, 1}, engine_options(options.threads, options.stop, options.progress));
  return judge_played(configuration, std::move(played.front()),
                      engine_options(options.threads, options.stop));
}

}  // namespace credence
