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
#include "reports/document/judgement_report.h"
#include "reports/document/study_json.h"
#include "reports/document/study_report.h"
#include "reports/document/study_table.h"
#include "reports/document/sweep_report.h"
#include "reports/document/tune_report.h"
#include "reports/document/tuning_tables.h"
#include "reports/render/text_table.h"

namespace credence {
namespace {

std::string study_text(const StudyAnalysis& analysis) {
  std::string text = text_table(verdict_table(std::span(&analysis, 1)));
  if (analysis.stop) text += stop_sentence(analysis) + "\n";
  if (!analysis.judgement) return text;
  for (const std::string& sentence : advice_sentences(*analysis.judgement)) text += sentence + "\n";
  return text;
}

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

std::string sweep_text(const SweepAnalysis& analysis) {
  std::string text;
  for (const ReportTable& table : sweep_tables(analysis)) text += text_table(table);
  return text;
}

std::string tune_text(const ScenarioTuning& tuning) {
  std::string text;
  for (const ReportTable& table :
       {tune_forecast_table(tuning.tuning.forecast), tune_table(tuning), tune_gain_table(tuning)}) {
    text += text_table(table) + "\n";
  }
  for (const std::string& sentence : tune_sentences(tuning)) text += sentence + "\n";
  return text;
}

}  // namespace

Told tell(JudgedFilter judged) {
  const auto filter = std::make_shared<const JudgedFilter>(std::move(judged));
  return {.verdict = std::string(to_string(filter->verdict())),
          .says = filter->says(),
          .p_value = filter->p_value(),
          .text = [filter] { return filter->text(); },
          .json = [filter] { return filter->json(); },
          .write_report = [filter](const std::filesystem::path& folder) { filter->write_report(folder); }};
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
  const auto a = std::make_shared<const StudyAnalysis>(std::move(all.front()));
  return {.verdict = std::string(to_string(overall_verdict(*a))),
          .says = JudgedFilter::word_says(a->word, a->nees),
          .p_value = a->word.p_value,
          .complete = a->complete,
          .text = [a] { return study_text(*a); },
          .json = [a] { return study_json(*a); },
          .write_report =
              [a, experiment](const std::filesystem::path& folder) {
                const ReportedStudy reported{*a, experiment->trace(0)};
                write_study_report(folder, a->scenario.name, std::span(&reported, 1));
              }};
}

Told told_sweep(SweepPlan plan, const Sources& sources) {
  std::vector<Scenario> scenarios;
  std::vector<std::shared_ptr<const Experiment>> experiments;
  for (const SweepPoint& point : plan.points) {
    scenarios.push_back(point.scenario);
    experiments.push_back(make_experiment(point.scenario));
  }
  const auto a = std::make_shared<const SweepAnalysis>(
      analyse_sweep(std::move(plan), studies(scenarios, experiments, sources.studies)));
  return {.verdict = "",
          .says = "",
          .p_value = kNaN,
          .complete = a->studies.size() == scenarios.size(),
          .is_sweep = true,
          .text = [a] { return sweep_text(*a); },
          .json = [a] { return sweep_json(*a); },
          .write_report = [a](const std::filesystem::path& folder) { write_sweep_report(folder, *a); }};
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
  const auto t = std::make_shared<const ScenarioTuning>(std::move(*tuned));
  const StudyAnalysis* const after = t->held_out ? &t->held_out->after : nullptr;
  return {.verdict = after == nullptr ? "" : std::string(to_string(overall_verdict(*after))),
          .says = after == nullptr ? "" : after->word.says,
          .p_value = after == nullptr ? kNaN : after->word.p_value,
          .complete = true,
          .text = [t] { return tune_text(*t); },
          .json = [t] { return tune_json(*t); },
          .tuned = [t] { return t->tuning.anything_known() ? tuned_toml(*t) : std::string(); },
          .write_report = [t](const std::filesystem::path& folder) { write_tune_report(folder, *t); }};
}

}  // namespace credence
