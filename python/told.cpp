#include "python/told.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/sequential_study.h"
#include "analysis/evidence/study_analysis.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"
#include "reports/document/judgement_report.h"
#include "reports/document/study_json.h"
#include "reports/document/study_report.h"
#include "reports/document/study_table.h"
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

StudyAnalysis study(const Experiment& experiment, const Scenario& scenario, const EngineOptions& options) {
  SequentialStudy watch(scenario);
  StudyTask task{.id = "", .experiment = &experiment, .runs = scenario.most_runs()};
  task.max_seconds = scenario.stop.max_seconds;
  std::optional<StopDecision> stop;
  if (scenario.stop.asked()) {
    task.enough = [&](const StudyStatistics& chunk, const StudyStatistics& prefix) {
      return watch.look(chunk, prefix);
    };
  }
  StudyResult result = std::move(run_studies(std::span(&task, 1), options).front());
  if (scenario.stop.asked()) stop = watch.decision();
  StudyAnalysis analysis = analyse_study(scenario, experiment, std::move(result), stop);
  add_judgement(analysis, experiment, options);
  return analysis;
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

Told run_scenario(const Scenario& scenario, int threads, const std::atomic<bool>& stop) {
  EngineOptions options;
  options.threads = threads;
  options.stop = &stop;
  const std::shared_ptr<const Experiment> experiment = make_experiment(scenario);
  const auto a = std::make_shared<const StudyAnalysis>(study(*experiment, scenario, options));
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

}  // namespace credence
