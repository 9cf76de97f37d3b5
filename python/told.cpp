#include "python/told.h"

#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/sequential_study.h"
#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sweep_analysis.h"
#include "analysis/tuning/tune_scenario.h"
#include "core/nan.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study_report.h"
#include "reports/document/sweep_report.h"
#include "reports/document/tune_report.h"

namespace credence {
namespace {

/// One study for each experiment of these scenarios; of those without a run nothing. The evidence, if any, is
/// that of a single one.
std::vector<StudyAnalysis> studies(std::span<const Scenario> scenarios,
                                   std::span<const std::shared_ptr<const Experiment>> experiments,
                                   const EngineOptions& options, EvidenceCollector* evidence = nullptr) {
  std::vector<SequentialStudy> watches(scenarios.begin(), scenarios.end());
  std::vector<StudyTask> tasks;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const StopSettings& stop = scenarios[i].stop;
    StudyTask& task = tasks.emplace_back(StudyTask{.id = configuration_id(scenarios[i]),
                                                   .experiment = experiments[i].get(),
                                                   .runs = scenarios[i].most_runs()});
    task.max_seconds = stop.max_seconds;
    if (evidence != nullptr) evidence->keep_with(task);
    if (!stop.asked()) continue;
    task.enough = [&watch = watches[i]](const StudyStatistics& chunk, const StudyStatistics& prefix) {
      return watch.look(chunk, prefix);
    };
  }
  std::vector<StudyResult> results = run_studies(tasks, options);
  std::vector<StudyAnalysis> analyses;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].statistics.runs == 0) continue;
    std::optional<StopDecision> stop;
    if (scenarios[i].stop.asked()) stop = watches[i].decision();
    analyses.push_back(analyse_study(scenarios[i], *experiments[i], std::move(results[i]), stop));
  }
  return analyses;
}

}  // namespace

Told tell(JudgedFilter filter) {
  return {.verdict = std::string(to_string(filter.verdict())),
          .says = filter.says(),
          .p_value = filter.p_value(),
          .document = filter.document()};
}

namespace {

/// Where the runs come from, and what explains them.
struct Sources {
  EngineOptions studies, evidence;
};

Sources played(int threads, const std::atomic<bool>& stop) {
  EngineOptions options;
  options.threads = threads;
  options.stop = &stop;
  return {options, options};
}

Told told_scenario(const Scenario& scenario, const Sources& sources) {
  const std::shared_ptr<const Experiment> experiment = make_experiment(scenario);
  EvidenceCollector evidence(*experiment, evidence_runs(scenario, scenario.most_runs()));
  std::vector<StudyAnalysis> all =
      studies(std::span(&scenario, 1), std::span(&experiment, 1), sources.studies, &evidence);
  if (all.empty()) throw std::runtime_error("interrupted before the first runs were done");
  add_judgement(all.front(), evidence, sources.evidence);
  add_posterior_bound(all.front(), sources.evidence);
  StudyAnalysis& a = all.front();
  Told told{.verdict = std::string(to_string(overall_verdict(a))),
            .says = JudgedFilter::word_says(a.word, a.nees),
            .p_value = a.word.p_value,
            .complete = a.complete};
  std::vector<ReportedStudy> reported;
  reported.push_back({std::move(a), experiment->trace(0)});
  told.document = study_document(std::move(reported));
  return told;
}

Told told_sweep(SweepPlan plan, const Sources& sources) {
  std::vector<Scenario> scenarios;
  std::vector<std::shared_ptr<const Experiment>> experiments;
  for (const SweepPoint& point : plan.points) {
    scenarios.push_back(point.scenario);
    experiments.push_back(make_experiment(point.scenario));
  }
  SweepAnalysis analysis = analyse_sweep(std::move(plan), studies(scenarios, experiments, sources.studies));
  const bool complete = analysis.studies.size() == scenarios.size();
  return {.p_value = kNaN,
          .complete = complete,
          .is_sweep = true,
          .document = sweep_document(std::move(analysis))};
}

}  // namespace

Told run_scenario(const Scenario& scenario, int threads, const std::atomic<bool>& stop) {
  return told_scenario(scenario, played(threads, stop));
}

Told run_sweep(const ScenarioDocument& document, int threads, const std::atomic<bool>& stop) {
  return told_sweep(plan_sweep(document), played(threads, stop));
}

Told load_stored(const std::filesystem::path& directory, int threads, const std::atomic<bool>& stop) {
  static constexpr std::atomic<bool> kNothingNew{true};
  ResultStore store = ResultStore::open_to_read(directory);
  SweepPlan plan = plan_sweep(read_scenario_text(store.scenario(), directory.string()));
  if (std::string name = store.name(); !name.empty()) plan.name = std::move(name);
  for (SweepPoint& point : plan.points) point.scenario.name = plan.name;
  Sources sources = played(threads, stop);
  sources.studies.stop = &kNothingNew;
  sources.studies.store = &store;
  if (!plan.axes.empty()) return told_sweep(std::move(plan), sources);
  if (store.chunks(configuration_id(plan.points.front().scenario)).empty()) {
    throw StoreError(directory.string() + ": no runs are stored yet");
  }
  return told_scenario(plan.points.front().scenario, sources);
}

Told tune(const Scenario& scenario, const std::string& free, int threads, const std::atomic<bool>& stop) {
  TuneRequest request;
  request.free = parse_free_noise(free);
  request.threads = threads;
  request.stop = &stop;
  std::optional<ScenarioTuning> tuned = tune_scenario(scenario, request);
  if (!tuned) throw std::runtime_error("interrupted before the tuning was done");
  const StudyAnalysis* const after = tuned->held_out ? &tuned->held_out->after : nullptr;
  Told told{.verdict = after == nullptr ? "" : std::string(to_string(overall_verdict(*after))),
            .says = after == nullptr ? "" : after->word.says,
            .p_value = after == nullptr ? kNaN : after->word.p_value,
            .tuned = tuned->tuning.anything_known() ? tuned_toml(*tuned) : ""};
  told.document = tune_document(std::move(*tuned));
  return told;
}

}  // namespace credence
