#include "python/told.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/play_studies.h"
#include "analysis/evidence/sweep_analysis.h"
#include "analysis/tuning/tune_scenario.h"
#include "core/nan.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/judge/judge_scenario.h"
#include "reports/document/judge/judged.h"
#include "reports/document/sweep/sweep_report.h"
#include "reports/document/tuning/tune_report.h"

namespace credence::internal {
namespace {

EngineOptions engine_options(int threads, const std::atomic<bool>& stop) {
  EngineOptions options;
  options.threads = threads;
  options.stop = &stop;
  return options;
}

Told told_sweep(SweepPlan plan, const EngineOptions& options) {
  std::vector<std::unique_ptr<const Experiment>> experiments;
  std::vector<StudyToPlay> studies;
  for (const SweepPoint& point : plan.points) {
    experiments.push_back(make_experiment(point.scenario));
    studies.push_back({configuration_id(point.scenario), &point.scenario, experiments.back().get()});
  }
  std::vector<StudyAnalysis> analyses;
  std::vector<PlayedStudy> results = play_studies(studies, options);
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].result.statistics.runs == 0) continue;
    analyses.push_back(
        analyse_study(*studies[i].scenario, *experiments[i], std::move(results[i].result), results[i].stop));
  }
  SweepAnalysis analysis = analyse_sweep(std::move(plan), std::move(analyses));
  const bool complete = analysis.studies.size() == experiments.size();
  return {.p_value = kNaN,
          .complete = complete,
          .is_sweep = true,
          .document = sweep_document(std::move(analysis))};
}

}  // namespace

Told tell(const JudgedFilter& filter) {
  return {.verdict = std::string(to_string(filter.verdict())),
          .says = filter.says(),
          .p_value = filter.p_value(),
          .complete = filter.complete(),
          .document = filter.judged().document};
}

Told run_scenario(const Scenario& scenario, int threads, const std::atomic<bool>& stop) {
  return tell(judge_scenario(scenario, {.threads = threads, .stop = &stop}));
}

Told run_sweep(const ScenarioDocument& document, int threads, const std::atomic<bool>& stop) {
  return told_sweep(plan_sweep(document), engine_options(threads, stop));
}

Told load_stored(const std::filesystem::path& directory, int threads, const std::atomic<bool>& stop) {
  static constexpr std::atomic<bool> kNothingNew{true};
  ResultStore store = ResultStore::open_to_read(directory);
  SweepPlan plan = plan_sweep(read_scenario_text(store.scenario(), directory.string()));
  if (std::string name = store.name(); !name.empty()) plan.name = std::move(name);
  for (SweepPoint& point : plan.points) point.scenario.name = plan.name;
  EngineOptions stored = engine_options(threads, kNothingNew);
  stored.store = &store;
  if (!plan.axes.empty()) return told_sweep(std::move(plan), stored);
  if (store.chunks(configuration_id(plan.points.front().scenario)).empty()) {
    throw StoreError(directory.string() + ": no runs are stored yet");
  }
  return tell(judge_study(plan.points.front().scenario, stored, engine_options(threads, stop)));
}

Told tune(const Scenario& scenario, const std::string& free, int threads, const std::atomic<bool>& stop) {
  TuneRequest request;
  request.free = parse_free_noise(free);
  request.threads = threads;
  request.stop = &stop;
  std::optional<ScenarioTuning> tuned = tune_scenario(scenario, request);
  if (!tuned) throw std::runtime_error("interrupted before the tuning was done");
  tuned->score->forget_stop();  // the document's figures ask it for more, long after this call
  const StudyAnalysis* const after = tuned->held_out ? &tuned->held_out->after : nullptr;
  Told told{.verdict = after == nullptr ? "" : std::string(to_string(overall_verdict(*after))),
            .says = after == nullptr ? "" : after->word.says,
            .p_value = after == nullptr ? kNaN : after->word.p_value,
            .tuned = tuned->tuning.anything_known() ? tuned_toml(*tuned) : ""};
  told.document = tune_document(std::move(*tuned));
  return told;
}

}  // namespace credence::internal
