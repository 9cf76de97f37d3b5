#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <stdexcept>

#include "analysis/studies/estimator_map.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/naming_file.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/scenario_files.h"
#include "app/shell_word.h"
#include "app/tell.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/estimators/estimator_map_report.h"
#include "reports/document/estimators/estimator_report.h"

namespace credence::internal {
namespace {

struct EstimatorsCommand : CommonOptions {
  std::string scenario;
  EstimatorStudyOptions study;
};

bool any_failed(const EstimatorStudy& study) {
  return std::ranges::any_of(study.rows, [](const EstimatorRow& row) { return !row.failures.empty(); });
}

/// Every point of a sweep; the cheapest that stays consistent at each.
int map_of_sweep(const EstimatorsCommand& command, const SweepPlan& plan) {
  if (command.fail_on_inconsistent) {
    throw ScenarioError(fmt::format(
        "{}: [sweep]: --fail-on-inconsistent is of one study; a map has a verdict for each of its points",
        command.scenario));
  }
  const EstimatorMap map = naming_file(command.scenario, [&] { return map_estimators(plan, command.study); });
  if (!map.complete) {
    say("credence: estimators interrupted, nothing is compared");
    return kInterrupted;
  }
  tell(estimator_map_document(map), command);
  return std::ranges::any_of(map.studies, any_failed) ? kSomeFailed : kDone;
}

/// The same one twice would be another one to Holm's procedure.
void require_each_once(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::count(names, name) > 1)
      throw std::invalid_argument(fmt::format("--estimators: {} is named twice", name));
  }
}

int estimators(EstimatorsCommand& command) {
  require_each_once(command.study.estimators);
  const SweepPlan plan = open_sweep(command.scenario, command.overrides());
  ProgressDisplay display("estimators", command.quiet);
  command.study.threads = command.threads;
  command.study.stop = &catch_interrupt();
  command.study.ranks = launched_ranks();
  command.study.progress = [&](const StudyProgress& progress) { display.show(progress); };
  tell_of_stop_rule(plan.points.front().scenario, "estimators");
  for (const std::string& setting : command.settings) {
    if (setting.starts_with("filter.estimator="))
      say("credence: --set " + setting + " is left aside: --estimators says which are compared");
  }
  if (!plan.axes.empty()) return map_of_sweep(command, plan);
  command.study.run_command = "credence run " + shell_word(command.scenario);
  for (const std::string& setting : command.overrides())
    command.study.run_command += " --set " + shell_word(setting);
  const EstimatorStudy study = naming_file(
      command.scenario, [&] { return study_estimators(plan.points.front().scenario, command.study); });
  if (!study.complete) {
    say("credence: estimators interrupted, nothing is compared");
    return kInterrupted;
  }
  tell(estimator_document(study), command);
  if (any_failed(study)) return kSomeFailed;
  return command.fail_on_inconsistent && any_inconsistent(study) ? kInconsistent : kDone;
}

}  // namespace

void add_estimators_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "estimators", "several estimators on one world with common noise: the consistency table");
  auto options = std::make_shared<EstimatorsCommand>();
  std::vector<std::string> names;
  for (const World* world : worlds()) {
    if (world->estimators == nullptr) continue;
    for (const std::string_view name : world->estimators->names(nullptr)) {
      if (std::ranges::find(names, name) == names.end()) names.emplace_back(name);
    }
  }
  command
      ->add_option("scenario", options->scenario,
                   "scenario file of a world that offers estimators; with a [sweep] table: a map of the "
                   "cheapest that stays consistent")
      ->required();
  command->add_option("--estimators", options->study.estimators, "those to compare; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  add_common_options(*command, *options);
  command->get_option("--fail-on-inconsistent")
      ->description(
          "exit with 1 when the pose or the map of an estimator is optimistic or pessimistic, all taken "
          "together (Holm)");
  static constexpr const char* kExamples[] = {
      "credence estimators ukfm_slam2d --out out/estimators    # two minutes of one core",
      "credence estimators huang_ring --estimators ekf,ideal,fej --runs 1000",
      "credence estimators huang_annulus --set world.map=7 --format json    # two minutes, too",
      "credence estimators estimator_map --runs 40 --estimators ekf,fej,invariant,schmidt --out out/map"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{estimators(*options)}; });
}

}  // namespace credence::internal
