#include "python/told.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/configuration.h"
#include "analysis/evidence/stored_study.h"
#include "analysis/evidence/sweep_analysis.h"
#include "analysis/tuning/tune_scenario.h"
#include "core/nan.h"
#include "montecarlo/engine/result_store_error.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/judge/judged.h"
#include "reports/document/sweep/sweep_report.h"
#include "reports/document/tuning/tune_report.h"

namespace credence::internal {
namespace {

Told told_sweep(SweepPlan plan, std::vector<StudyAnalysis> analyses) {
  const bool complete = analyses.size() == plan.points.size();
  return {.p_value = kNaN,
          .complete = complete,
          .is_sweep = true,
          .document = sweep_document(analyse_sweep(std::move(plan), std::move(analyses)))};
}

}  // namespace

Told tell(const JudgedFilter& filter) {
  return {.verdict = std::string(to_string(filter.verdict())),
          .says = filter.says(),
          .p_value = filter.p_value(),
          .complete = filter.complete(),
          .document = filter.judged().document};
}

Told run_scenario(const Scenario& scenario, const PlayOptions& options) {
  return tell(judge_scenario(scenario, options));
}

Told run_sweep(const ScenarioDocument& document, const PlayOptions& options) {
  SweepPlan plan = plan_sweep(document);
  std::vector<Configuration> configurations;
  for (const SweepPoint& point : plan.points) configurations.push_back(make_configuration(point.scenario));
  std::vector<PlayedStudy> played =
      play(configurations, engine_options(options.threads, options.stop, options.progress));
  return told_sweep(std::move(plan), analyses_of(configurations, std::move(played)));
}

Told load_stored(const std::filesystem::path& directory, const PlayOptions& options) {
  StoredStudy study = read_study(directory);
  if (study.is_sweep()) {
    std::vector<StudyAnalysis> analyses = analyse(study);
    return told_sweep(std::move(study.plan), std::move(analyses));
  }
  require_runs(study);
  return tell(judge_played(study.configurations.front(), std::move(study.results.front()),
                           engine_options(options.threads, options.stop, options.progress)));
}

Told tune(const Scenario& scenario, const std::string& free, const PlayOptions& options) {
  const EngineOptions fresh = engine_options(options.threads, options.stop, options.progress);
  TuneRequest request;
  request.free = parse_free_noise(free);
  request.threads = fresh.threads;
  request.stop = fresh.stop;
  request.progress = fresh.progress;
  if (options.progress) {
    request.watch = [progress = options.progress](double plays) {
      progress(static_cast<std::int64_t>(plays), 0);
    };
  }
  std::optional<ScenarioTuning> tuned = tune_scenario(scenario, request);
  if (!tuned) throw std::runtime_error("interrupted before the tuning was done");
  tuned->score->forget_stop();  // the document's figures ask it for more, long after this call
  const StudyAnalysis* const after = tuned->held_out ? &tuned->held_out->after : nullptr;
  Told told{.verdict = after == nullptr ? "" : std::string(to_string(overall_verdict(*after))),
            .says = after == nullptr ? "" : overall_says(*after),
            .p_value = after == nullptr ? kNaN : overall_p_value(*after),
            .tuned = tuned->tuning.anything_known() ? tuned_toml(*tuned) : ""};
  told.document = tune_document(std::move(*tuned));
  return told;
}

}  // namespace credence::internal
