#include "app/study_runner.h"

#include "app/interrupt.h"
#include "app/progress.h"
#include "montecarlo/scenario_text.h"

namespace credence {

Configuration make_configuration(const Scenario& scenario) {
  return {configuration_id(scenario), scenario, make_experiment(scenario)};
}

std::vector<StudyResult> run_configurations(std::span<const Configuration> configurations,
                                            const std::string& canonical,
                                            const std::filesystem::path& store_directory,
                                            const std::string& what, const CommonOptions& options,
                                            Shard shard) {
  std::optional<ResultStore> store;
  if (!store_directory.empty()) {
    store.emplace(ResultStore::open_to_write(store_directory, CREDENCE_VERSION));
    store->require_same_scenario(canonical);
  }
  std::vector<StudyTask> tasks;
  for (const Configuration& c : configurations) {
    if (store) store->put_configuration(c.id, configuration_toml(c.scenario));
    tasks.push_back({c.id, c.experiment.get(), c.scenario.study.runs});
  }
  ProgressDisplay display(what, options.quiet);
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = &catch_interrupt();
  engine.store = store ? &*store : nullptr;
  engine.progress = [&](const StudyProgress& progress) { display.show(progress); };
  engine.shard = shard.number;
  engine.shards = shard.of;
  return run_studies(tasks, engine);
}

int study_exit_code(bool complete, bool any_failed, bool all_consistent, const CommonOptions& options) {
  if (!complete) return kInterrupted;
  if (any_failed) return kSomeFailed;
  return options.fail_on_inconsistent && !all_consistent ? kInconsistent : kDone;
}

}  // namespace credence
