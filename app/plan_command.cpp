#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/studies/study_plan.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/progress.h"
#include "app/scenario_files.h"
#include "app/tell.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/plan_report.h"

namespace credence::internal {
namespace {

struct PlanCommand : CommonOptions {
  std::string scenario;
  PlanQuestion question;
};

/// Points that get a pilot: all, or of a large sweep so many, evenly spread.
std::vector<const SweepPoint*> pilot_points(const SweepPlan& sweep) {
  constexpr std::size_t kMostPilots = 16;
  const std::size_t count = std::min(kMostPilots, sweep.points.size());
  std::vector<const SweepPoint*> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(&sweep.points[i * sweep.points.size() / count]);
  return points;
}

/// One after the other, with progress: by pilots, of a single one by its steps.
std::vector<StudyPlan> plans_of(const std::vector<const SweepPoint*>& points, const PlanCommand& command) {
  std::vector<StudyPlan> plans;
  const bool single = points.size() == 1;
  std::optional<StepDisplay> steps;
  if (single) steps.emplace("plan", command.quiet, "steps of a pilot");
  ProgressDisplay display("plan", command.quiet || single, "pilots");
  for (const SweepPoint* point : points) {
    plans.push_back(naming_file(command.scenario, [&] {
      return plan_study(point->scenario, *make_experiment(point->scenario), command.question);
    }));
    display.show({.runs_done = static_cast<std::int64_t>(plans.size()),
                  .runs_stored = 0,
                  .runs_total = static_cast<std::int64_t>(points.size())});
  }
  return plans;
}

int plan(PlanCommand& command) {
  require_answerable(command.question);
  command.question.threads = command.threads;
  command.question.stop = &catch_interrupt();
  const StopScope stop(command.question.stop);
  const SweepPlan sweep = open_sweep(command.scenario, command.overrides());
  command.question.evidence = sweep.points.size() == 1;
  print(plan_document(sweep, plans_of(pilot_points(sweep), command)), command);
  return kDone;
}

}  // namespace

void add_plan_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("plan", "runs needed for a wanted power or precision, and the time they take");
  auto options = std::make_shared<PlanCommand>();
  command
      ->add_option("scenario", options->scenario,
                   "scenario file, with or without a [sweep] table, or a name of credence list")
      ->required();
  command
      ->add_option("--factor", options->question.factor,
                   "true covariance over claimed, to be detected; its inverse is planned for too")
      ->capture_default_str();
  command->add_option("--power", options->question.power, "probability to detect it, in (0, 1)")
      ->capture_default_str();
  command
      ->add_option("--precision", options->question.precision, "relative half-width wanted of the mean NEES")
      ->capture_default_str();
  add_setting_option(*command, *options);
  add_threads_option(*command, options->threads);
  add_print_options(*command, *options);
  static constexpr const char* kExamples[] = {"credence plan figure1_two_landmarks",
                                              "credence plan planar_loop --factor 1.5 --power 0.95",
                                              "credence plan mistuned_sweep --precision 0.02 --format json"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{plan(*options)}; });
}

}  // namespace credence::internal
