#include "app/study_runner.h"

#include <fmt/format.h>

#include <stdexcept>

#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/progress.h"
#include "app/say.h"
#include "core/simd/cpu_dispatch.h"
#include "core/version.h"
#include "montecarlo/scenario/scenario_text.h"

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

}  // namespace

void explain(StudyAnalysis& analysis, const Configuration& configuration, const CommonOptions& options) {
  ProgressDisplay display(configuration.scenario.name + ", further tests", options.quiet);
  EngineOptions engine;
  engine.threads = options.threads;
  engine.stop = &catch_interrupt();
  engine.progress = [&](const StudyProgress& progress) { display.show(progress); };
  explain(analysis, configuration, engine);
}

std::optional<StudyAnalysis> judge(const StoredStudy& study, const CommonOptions& options) {
  std::vector<StudyAnalysis> analyses = analyse(study);
  if (analyses.empty()) return std::nullopt;
  explain(analyses.front(), study.configurations.front(), options);
  if (!analyses.front().judgement) return std::nullopt;
  return std::move(analyses.front());
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

int study_exit_code(bool complete, bool any_failed, bool any_inconsistent, const CommonOptions& options) {
  if (!complete) return kInterrupted;
  if (any_failed) return kSomeFailed;
  return options.fail_on_inconsistent && any_inconsistent ? kInconsistent : kDone;
}

}  // namespace credence::internal
