#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include "analysis/evidence/sweep_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/naming_file.h"
#include "app/say.h"
#include "app/scenario_files.h"
#include "app/study_runner.h"
#include "app/tell.h"
#include "core/append_item.h"
#include "core/memory_need.h"
#include "core/version.h"
#include "montecarlo/scenario/scenario_difference.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/sweep/shard_report.h"
#include "reports/document/sweep/sweep_report.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {

namespace fs = std::filesystem;

namespace {

struct SweepOptions : CommonOptions {
  std::string scenario;
  std::string shard = "1/1";
};

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  if (number.ec == std::errc{} && number.ptr != end && *number.ptr == '/') {
    const auto of = std::from_chars(number.ptr + 1, end, shard.of);
    if (of.ec == std::errc{} && of.ptr == end && 1 <= shard.number && shard.number <= shard.of) return shard;
  }
  throw ScenarioError(fmt::format("--shard {}: accepted are i/n with 1 <= i <= n, as in 2/4", text));
}

/// Whoever types `sweep` expects several configurations: that there is but one is said.
void tell_of_no_sweep(const std::string& file, const SweepPlan& plan) {
  if (!plan.axes.empty() || is_helper(launched_ranks())) return;
  say(fmt::format(
      "{0} has no [sweep] that varies a key, so that this is its one configuration, as credence run {0} "
      "plays it; to vary one: a [sweep] table, or --set sweep.SECTION.KEY=VALUES",
      file));
}

ShardRuns runs_of(const Shard& shard, const std::vector<PlayedStudy>& results, const std::string& directory) {
  ShardRuns runs{.number = shard.number, .of = shard.of, .directory = directory, .configurations = {}};
  for (const PlayedStudy& played : results) {
    runs.configurations.push_back({played.result.shard_runs, played.result.shard_runs_done});
  }
  return runs;
}

int sweep(SweepOptions& options) {
  const Shard shard = parse_shard(options.shard);
  if (shard.of > 1 && options.fail_on_inconsistent)
    throw ScenarioError(
        "--fail-on-inconsistent: a shard has no verdict; merge them, and run the sweep on the joined ones");
  const SweepPlan plan = open_sweep(options.scenario, options.overrides());
  tell_of_no_sweep(options.scenario, plan);
  const std::string canonical = canonical_toml(plan);
  if (options.out.empty()) options.out = default_directory(plan).string();

  std::vector<Configuration> configurations;
  std::vector<PlayedStudy> results = naming_file(options.scenario, [&] {
    double bytes = 0.0;
    for (const SweepPoint& point : plan.points) bytes += least_experiment_bytes(point.scenario);
    require_memory(bytes, fmt::format("[sweep] of {} points with study.runs = {}", plan.points.size(),
                                      plan.points.front().scenario.most_runs()));
    for (const SweepPoint& point : plan.points) {
      require_storable(point.scenario);
      configurations.push_back(make_configuration(point.scenario));
    }
    return run_configurations(configurations, canonical, options.out, plan.name, options, shard);
  });

  if (is_helper(launched_ranks())) return kDone;
  if (shard.of > 1) {
    // There is no verdict on a part, but what reads documents is told what was done.
    if (options.format == "json") print(shard_document(plan, runs_of(shard, results, options.out)), options);
    if (catch_interrupt().load()) return kInterrupted;
    if (!options.quiet) {
      say(fmt::format("Shard {} is stored in {}; join with credence merge", options.shard, options.out));
    }
    return kDone;
  }
  bool complete = true, failed = false;
  std::vector<StudyAnalysis> analyses;
  for (std::size_t i = 0; i < results.size(); ++i) {
    complete = complete && results[i].result.complete;
    if (results[i].result.statistics.runs == 0) continue;
    analyses.push_back(analyse(configurations[i], std::move(results[i])));
    configurations[i].experiment.reset();
    if (options.format != "json") forget_steps(analyses.back());
    failed = failed || !analyses.back().statistics.failures.empty();
  }
  const SweepAnalysis sweep = analyse_sweep(plan, std::move(analyses));
  bool inconsistent = false;
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) inconsistent = inconsistent || sweep.stands(i);
  tell(sweep_document(sweep), options);
  require_stored(options.out);
  return study_exit_code(complete, failed, inconsistent, options);
}

struct MergeOptions {
  std::vector<std::string> directories;
  std::string out;
};

/// Whatever is wrong with one of them by itself, or beside another, is said before anything is made.
void require_joinable(const std::vector<std::string>& directories) {
  std::string first, scenario;
  for (const std::string& directory : directories) {
    const std::string stored = ResultStore::open_to_read(directory).scenario();
    if (stored.empty()) continue;
    if (scenario.empty()) first = directory, scenario = stored;
    if (const std::string difference = scenario_difference(scenario, stored); !difference.empty()) {
      throw ScenarioError(fmt::format(
          "{0}: holds results of another scenario than {1} (- of {1}, + of {0}):\n{2}they cannot be joined",
          directory, first, difference));
    }
  }
}

/// The folders that have to be made for this one, itself first.
std::vector<fs::path> missing_folders(const fs::path& folder) {
  std::vector<fs::path> missing;
  for (fs::path above = folder.lexically_normal(); !above.empty() && !fs::exists(above);
       above = above.parent_path()) {
    missing.push_back(above);
  }
  return missing;
}

void join(const MergeOptions& options, ResultStore& target) {
  for (const std::string& directory : options.directories) {
    const ResultStore source = ResultStore::open_to_read(directory);
    target.require_same_scenario(source.scenario());
    target.set_name(source.name());
    const auto count = target.merge_from(source);
    fmt::print("{}: {} added, {} there already\n", printable_line(directory), counted(count.added, "chunk"),
               count.already_there);
  }
  target.commit();
}

int merge(const MergeOptions& options) {
  require_joinable(options.directories);
  std::vector<fs::path> missing = missing_folders(options.out);
  // What is empty when this fails and is not now, another merge has made and taken back.
  if (fs::is_directory(options.out) && !fs::is_empty(options.out)) missing.emplace_back(options.out);
  std::optional<ResultStore> target;
  try {
    target.emplace(ResultStore::open_to_write(options.out, version()));
    join(options, *target);
  } catch (...) {
    // What is refused leaves nothing but what was there before, or what another process has put there since.
    if (target) target->take_back();
    std::error_code is_used;
    for (const fs::path& folder : missing) fs::remove(folder, is_used);
    throw;
  }
  return kDone;
}

}  // namespace

void add_sweep_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("sweep", "all configurations of a [sweep] table; resumes by itself");
  auto options = std::make_shared<SweepOptions>();
  command
      ->add_option("scenario", options->scenario,
                   "scenario file with a [sweep] table, or a name of credence list")
      ->required();
  add_common_options(*command, *options);
  command->get_option("--out")->description(
      "folder for report, figures and stored results; without it out/NAME-HASH of the file and its settings");
  command->get_option("--figures")->remove_needs(command->get_option("--out"));  // there is always a folder
  command->add_option("--shard", options->shard, "run only part i of n, to be merged")
      ->type_name("i/n")
      ->capture_default_str();
  static constexpr const char* kExamples[] = {
      "credence sweep mistuned_sweep",
      "credence sweep mistuned_sweep --set sweep.world.landmarks=1:4 --out out/landmarks",
      "credence sweep mistuned_sweep --shard 1/2 --out out/part1",
      "credence sweep rank_map    # when does inflation keep P bounded?"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] { throw ExitStatus{sweep(*options), true}; });
}

void add_merge_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("merge", "joins the stored results of shards");
  auto options = std::make_shared<MergeOptions>();
  command->add_option("directories", options->directories, "folders of shards")->required();
  command->add_option("--out", options->out, "folder for the joined results")
      ->required()
      ->check(writable_folder);
  static constexpr const char* kExamples[] = {"credence sweep mistuned_sweep --shard 1/2 --out out/part1",
                                              "credence sweep mistuned_sweep --shard 2/2 --out out/part2",
                                              "credence merge out/part1 out/part2 --out out/joined",
                                              "credence report out/joined    # and credence show out/joined"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{merge(*options)}; });
}

}  // namespace credence::internal
