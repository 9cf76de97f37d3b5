#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/logged_experiment.h"
#include "app/naming_file.h"
#include "app/say.h"
#include "app/scenario_files.h"
#include "app/shell_word.h"
#include "app/study_runner.h"
#include "app/tell.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/study_report.h"
#include "reports/document/study/trace_report.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

struct RunOptions : CommonOptions {
  std::vector<std::string> scenarios;
  std::optional<std::int64_t> only_run;
  bool fresh = false;
  std::string log, log_format = "csv";
};

/// One run alone, with everything in it.
int show_one_run(const RunOptions& options) {
  if (options.scenarios.size() != 1) throw ScenarioError("--only-run: accepts exactly one scenario");
  if (*options.only_run < 0) throw ScenarioError("--only-run: must not be negative");
  const Scenario scenario = open_one_scenario(options.scenarios.front(), options.overrides());
  if (*options.only_run >= scenario.most_runs()) {
    throw ScenarioError(fmt::format("--only-run {}: the runs of this study are 0 to {}", *options.only_run,
                                    scenario.most_runs() - 1));
  }
  const RunTrace trace = naming_file(options.scenarios.front(),
                                     [&] { return make_experiment(scenario)->trace(*options.only_run); });
  print(trace_document(scenario, trace), options);
  return trace.outcome == Outcome::ok ? kDone : kSomeFailed;
}

/// `run` is of one configuration: what else the file asks for is said, not left out in silence.
void tell_of_sweep(const std::string& file) {
  if (open_scenario(file).sweep.empty()) return;
  say(fmt::format("{} has a [sweep], which run leaves aside; all of its configurations: credence sweep {}",
                  file, file));
}

/// Several scenarios are told apart by their names, in folders of --out and --log.
void require_names(const RunOptions& options, const std::vector<Configuration>& configurations) {
  if (configurations.size() == 1 || (options.out.empty() && options.log.empty())) return;
  std::set<std::string> names;
  for (std::size_t i = 0; i < configurations.size(); ++i) {
    const std::string& name = configurations[i].scenario.name;
    if (name == "." || name == ".." || name == "index.html" || name == "figures") {
      throw ScenarioError(fmt::format("{}: give the file another name: a folder cannot be called {}",
                                      options.scenarios[i], name));
    }
    if (!names.insert(name).second) {
      throw ScenarioError(fmt::format("{}: another scenario is called {} too; both would get one folder",
                                      options.scenarios[i], name));
    }
  }
}

/// Where the results of one of several scenarios are stored; empty without --out.
fs::path store_directory(const RunOptions& options, const Scenario& scenario) {
  if (options.out.empty()) return {};
  return options.scenarios.size() == 1 ? fs::path(options.out) : fs::path(options.out) / scenario.name;
}

/// Where the logs of one of several scenarios go.
fs::path log_directory(const RunOptions& options, const Scenario& scenario) {
  return options.scenarios.size() == 1 ? fs::path(options.log) : fs::path(options.log) / scenario.name;
}

/// The same, writing a log of every run; `c` must outlive it.
Configuration logged(const RunOptions& options, const Configuration& c) {
  const RunLogFormat format = options.log_format == "npz"    ? RunLogFormat::npz
                              : options.log_format == "mcap" ? RunLogFormat::mcap
                                                             : RunLogFormat::csv;
  return {c.id, c.scenario,
          std::make_unique<LoggedExperiment>(*c.experiment, log_directory(options, c.scenario), format,
                                             options.fresh, step_s(c.scenario))};
}

/// Runs one configuration; with --log all of it, stored chunks or not, since every run is to be written.
PlayedStudy run_one(const RunOptions& options, const Configuration& c) {
  const bool stored = options.log.empty();
  PlayedStudy result = std::move(
      run_configurations(std::span(&c, 1), stored ? canonical_toml(c.scenario) : "",
                         stored ? store_directory(options, c.scenario) : "", c.scenario.name, options)
          .front());
  // Logs of runs that the result does not count, where there is one.
  if (!stored && result.result.statistics.runs > 0)
    discard_logs(log_directory(options, c.scenario), result.result.statistics.runs);
  return result;
}

int run(const RunOptions& options) {
  if (options.only_run) return show_one_run(options);
  if (!options.log.empty() && !options.out.empty() &&
      fs::weakly_canonical(fs::absolute(options.log)) == fs::weakly_canonical(fs::absolute(options.out)))
    throw std::invalid_argument(fmt::format(
        "--out {}: is the folder of --log, where the files of the report would be taken for logs; "
        "name another one",
        options.out));
  if (options.fresh && options.out.empty() && options.log.empty())
    throw ScenarioError("--fresh: without --out or --log there is nothing to discard");
  if (!options.log.empty() && launched_ranks() != nullptr)
    throw ScenarioError("--log: one process writes the logs; not under mpirun");
  std::vector<Configuration> configurations;
  for (const std::string& file : options.scenarios) {
    configurations.push_back(naming_file(file, [&] {
      const Scenario scenario = open_one_scenario(file, options.overrides());
      tell_of_sweep(file);
      if (!options.out.empty() && options.log.empty()) require_storable(scenario);
      return make_configuration(scenario);
    }));
  }
  require_names(options, configurations);
  std::vector<StudyAnalysis> analyses;
  for (std::size_t i = 0; i < configurations.size(); ++i) {
    Configuration& c = configurations[i];
    const fs::path directory = store_directory(options, c.scenario);
    if (options.fresh && !directory.empty() && !is_helper(launched_ranks())) ResultStore::discard(directory);
    naming_file(options.scenarios[i], [&] {
      std::optional<Configuration> with_logs;
      if (!options.log.empty()) with_logs = logged(options, c);
      Configuration& played = with_logs ? *with_logs : c;
      if (!is_helper(launched_ranks())) take_evidence(played);
      PlayedStudy result = run_one(options, played);
      if (result.result.statistics.runs == 0) return;
      analyses.push_back(analyse(c, std::move(result)));
      explain(analyses.back(), played, options);
    });
    if (catch_interrupt().load()) break;
  }
  if (analyses.empty()) {
    if (!options.log.empty()) {
      say(fmt::format(
          "credence: interrupted before the first runs were judged; those whose logs are in {} can "
          "be: credence check {}; --fresh begins anew",
          options.log, shell_word(options.log)));
    } else if (options.out.empty()) {
      say("credence: interrupted before the first runs were done");
    }
    return kInterrupted;
  }

  const auto complete = [](const StudyAnalysis& a) { return a.complete; };
  const auto failed = [](const StudyAnalysis& a) { return !a.statistics.failures.empty(); };
  const auto inconsistent = [](const StudyAnalysis& a) { return is_inconsistent(overall_verdict(a)); };
  const int code = study_exit_code(
      analyses.size() == configurations.size() && std::ranges::all_of(analyses, complete),
      std::ranges::any_of(analyses, failed), std::ranges::any_of(analyses, inconsistent), options);

  std::vector<ReportedStudy> studies;
  for (std::size_t i = 0; i < analyses.size(); ++i) {
    ReportedStudy& study = studies.emplace_back(ReportedStudy{.analysis = std::move(analyses[i])});
    if (options.out.empty()) continue;
    study.trace = configurations[i].experiment->trace_to_draw(run_to_draw(study.analysis));
    study.description = scenario_comment(options.scenarios[i]);
  }
  tell(study_document(std::move(studies)), options);
  for (std::size_t i = 0; i < analyses.size() && !options.out.empty() && options.log.empty(); ++i) {
    require_stored(store_directory(options, configurations[i].scenario));
  }
  return code;
}

}  // namespace

void add_run_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("run", "Monte Carlo of one configuration: can its covariance be trusted?");
  auto options = std::make_shared<RunOptions>();
  command->add_option("scenario", options->scenarios, "scenario files, or names of credence list scenarios")
      ->required();
  add_common_options(*command, *options);
  command->get_option("--out")->description(
      "folder for report, figures and stored results, which it continues");
  command->add_option("--only-run", options->only_run, "replay this single run (from 0) with its full trace")
      ->excludes(command->get_option("--out"));
  command
      ->add_option("--log", options->log,
                   "folder for a log of every run, which credence check can judge (docs/formats.md); "
                   "nothing is stored or continued then")
      ->type_name("DIR")
      ->check(writable_folder)
      ->excludes("--only-run");
  command
      ->add_option(
          "--log-format", options->log_format,
          "of --log; npz: the errors with P and the innovations with S as arrays of NumPy; mcap: the "
          "pose in the plane and its truth as a bag of ROS 2")
      ->check(CLI::IsMember({"csv", "npz", "mcap"}))
      ->capture_default_str()
      ->needs("--log");
  command->add_flag(
      "--fresh", options->fresh,
      "begin anew: discard the results stored in --out, and of --log the files of runs, run-NUMBER with "
      "the ending csv, npz or mcap; other logs stay");
  for (const char* name : {"--fresh", "--fail-on-inconsistent"})
    command->get_option("--only-run")->excludes(command->get_option(name));
  static constexpr const char* kExamples[] = {
      "credence run figure1_two_landmarks    # comes with the program: credence list",
      "credence run figure3_two_landmarks --runs 5000 --format json",
      "credence run planar_loop --set world.landmarks=20 --out out/planar",
      "credence run figure1_two_landmarks --only-run 17",
      "credence run figure1_two_landmarks --log out/logs --fresh && credence check out/logs"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] {
    const int code = run(*options);
    throw ExitStatus{code, !options->out.empty() && options->log.empty()};
  });
}

}  // namespace credence::internal
