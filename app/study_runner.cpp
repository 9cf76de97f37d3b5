#include "app/study_runner.h"

#include <fmt/format.h>

#include <atomic>
#include <stdexcept>

#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/progress.h"
#include "app/say.h"
#include "core/simd/cpu_dispatch.h"
#include "core/version.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {

void require_storable(const Scenario& scenario) {
  const double head = most_stored_bytes(0, kChunkRuns), step = most_stored_bytes(1, kChunkRuns) - head;
  const auto most = static_cast<std::int64_t>((ResultStore::kMostChunkBytes - head) / step);
  if (scenario.study.steps <= most) return;
  throw std::invalid_argument(
      fmt::format("study.steps = {}: at most {} can be stored", scenario.study.steps, most));
}

void require_stored(const std::filesystem::path& directory) {
  if (ResultStore::exists(directory)) return;
  throw StoreError(fmt::format("{}: the stored results were moved or removed while the report was written",
                               directory.string()));
}

namespace {

void refuse_stop_rules(std::span<const Configuration> configurations) {
  for (const Configuration& c : configurations) {
    if (!c.scenario.stop.asked()) continue;
    throw ScenarioError("--shard: not with study.stop, which must see the runs in their order");
  }
}

void say_if_slow(const CommonOptions& options) {
  if (options.quiet || multiplies_and_adds_at_once(best_instruction_set())) return;
  say("credence: without AVX2 and FMA this processor takes many times as long (docs/scale.md); a virtual "
      "machine may have been given a model that hides them");
}

std::vector<PlayedStudy> play(std::span<const Configuration> configurations, const EngineOptions& engine) {
  std::vector<StudyToPlay> studies;
  for (const Configuration& c : configurations) {
    studies.push_back({c.id, &c.scenario, c.experiment.get(), c.evidence.get()});
  }
  return play_studies(studies, engine);
}

}  // namespace

Configuration make_configuration(const Scenario& scenario) {
  return {.id = configuration_id(scenario), .scenario = scenario, .experiment = make_experiment(scenario)};
}

void take_evidence(Configuration& c) {
  const std::int64_t most = evidence_runs(c.scenario, c.scenario.most_runs());
  c.evidence = std::make_unique<EvidenceCollector>(*c.experiment, most);
}

StudyAnalysis analyse(const Configuration& configuration, PlayedStudy result) {
  return analyse_study(configuration.scenario, *configuration.experiment, std::move(result.result),
                       result.stop);
}

void explain(StudyAnalysis& analysis, const Configuration& configuration, const CommonOptions& options) {
  ProgressDisplay display(configuration.scenario.name + ", further tests", options.quiet);
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = &catch_interrupt();
  engine.progress = [&](const StudyProgress& progress) { display.show(progress); };
  if (configuration.evidence) {
    add_judgement(analysis, *configuration.evidence, engine);
  } else {
    add_judgement(analysis, *configuration.experiment, engine);
  }
  add_posterior_bound(analysis, engine);
}

std::vector<PlayedStudy> run_configurations(std::span<const Configuration> configurations,
                                            const std::string& canonical,
                                            const std::filesystem::path& store_directory,
                                            const std::string& what, const CommonOptions& options,
                                            Shard shard) {
  if (shard.of > 1) refuse_stop_rules(configurations);
  std::optional<ResultStore> store;
  if (!store_directory.empty() && !is_helper(launched_ranks())) {
    store.emplace(ResultStore::open_to_write(store_directory, version()));
    store->require_same_scenario(canonical);
    store->set_name(what);
    for (const Configuration& c : configurations)
      store->put_configuration(c.id, configuration_toml(c.scenario));
  }
  say_if_slow(options);
  ProgressDisplay display(what, options.quiet);
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = &catch_interrupt();
  engine.store = store ? &*store : nullptr;
  engine.progress = [&](const StudyProgress& progress) { display.show(progress); };
  engine.shard = shard.number;
  engine.shards = shard.of;
  engine.ranks = launched_ranks();
  return play(configurations, engine);
}

std::vector<PlayedStudy> stored_results(std::span<const Configuration> configurations, ResultStore& store) {
  static constexpr std::atomic<bool> kNothingNew{true};
  return play(configurations, {.threads = 1, .stop = &kNothingNew, .store = &store});
}

int study_exit_code(bool complete, bool any_failed, bool any_inconsistent, const CommonOptions& options) {
  if (!complete) return kInterrupted;
  if (any_failed) return kSomeFailed;
  return options.fail_on_inconsistent && any_inconsistent ? kInconsistent : kDone;
}

}  // namespace credence::internal
