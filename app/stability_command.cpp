#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "analysis/stability/lifted_model.h"
#include "analysis/stability/planar_stability.h"
#include "analysis/stability/stability_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/progress.h"
#include "app/scenario_files.h"
#include "app/tell.h"
#include "core/append_item.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/stability/planar_stability_report.h"
#include "reports/document/stability/stability_report.h"
#include "reports/document/sweep/planar_table_report.h"

namespace credence::internal {
namespace {

struct StabilityOptions : CommonOptions {
  std::string scenario;
  Index horizon = 2000;
  Index loops = 20;
  const CLI::App* command = nullptr;  ///< tells which options were given
};

/// Throws ScenarioError for options that only worlds of the other kind have.
void require_no_option_of_others(const StabilityOptions& options, bool linear) {
  const auto others = linear ? std::vector<std::string>{"--loops", "--seed"}
                             : std::vector<std::string>{"--horizon", "--steps"};
  for (const std::string& name : others) {
    if (options.command->get_option(name)->count() == 0) continue;
    throw ScenarioError(fmt::format("{}: {}: only of {} worlds; this one is {}", options.scenario, name,
                                    linear ? "planar" : "linear", linear ? "linear" : "planar"));
  }
}

/// The names of the states, but for a SLAM state, whose symmetries have names.
std::vector<std::string> own_names(const Scenario& scenario, const LinearProblem& problem) {
  const bool slam = world_of(scenario).figure != RunFigure::states;
  return slam ? std::vector<std::string>{} : problem.scene.layout.states;
}

/// The keys that R is made of which the filter of such a world assumes.
std::string keys_of_measurement_noise(const Scenario& scenario) {
  std::string keys;
  for (const auto& [section, name] : {std::pair{"noise", "measurement_variance"},
                                      {"noise", "position_std"},
                                      {"world", "R"},
                                      {"filter", "R"},
                                      {"filter", "measurement_scale"}}) {
    const ScenarioKey* const key = find_scenario_key(section, name);
    if (key != nullptr && key->of_world(scenario.world.model)) append_item(keys, key->path());
  }
  return keys;
}

/// Throws std::invalid_argument, which the Riccati equation would without the names of keys.
void require_measurement_noise(const Scenario& scenario, const LinearModel& model) {
  if (model.R.llt().info() == Eigen::Success) return;
  throw std::invalid_argument(fmt::format("R of the filter is not positive definite: it follows from {}",
                                          keys_of_measurement_noise(scenario)));
}

Document linear_stability(const Scenario& scenario, const LinearProblem& problem,
                          const StabilityOptions& options) {
  const std::vector<LinearModel> period = problem.assumed_period();
  const Index length = std::ssize(period), steps = std::max<Index>(1, scenario.study.steps / length);
  const LinearModel model = lifted_model(period);
  require_measurement_noise(scenario, model);
  const StabilityAnalysis analysis =
      analyse_stability(model, problem.rule, steps, std::max({options.horizon / length, steps, Index{4}}),
                        own_names(scenario, problem));
  return stability_document(scenario, analysis, length);
}

/// Throws ScenarioError for what no recursion of a single covariance can answer.
void require_one_covariance(const Scenario& scenario, const std::string& file) {
  if (scenario.noise.detection_probability == 1.0) return;
  throw ScenarioError(fmt::format(
      "{}: noise.detection_probability = {}: where measurements are missed at random every run has a "
      "covariance of its own; stability accepts 1, and `credence run` shows the mean covariance",
      file, scenario.noise.detection_probability));
}

/// Throws ScenarioError for a world that is neither linear nor driven along a path, and for an inflation that
/// the latter has not.
void require_path(const Scenario& scenario, const std::string& file) {
  if (world_of(scenario).figure != RunFigure::plane_slam) {
    throw ScenarioError(fmt::format("{}: {}: stability handles linear worlds and the planar one", file,
                                    world_text(scenario)));
  }
  if (scenario.filter.inflation != FilterInflation::rank) return;
  throw ScenarioError(fmt::format(
      "{}: filter.inflation = \"rank\": in a planar world stability handles \"none\", \"full\" and \"map\"",
      file));
}

/// All points of a sweep, in parallel.
std::vector<PlanarStability> analyse_points(const SweepPlan& plan, const StabilityOptions& options) {
  for (const SweepPoint& point : plan.points) {
    if (linear_problem(point.scenario)) {
      throw ScenarioError(
          fmt::format("{}: [sweep]: stability compares planar worlds only; `credence sweep` "
                      "compares linear ones",
                      options.scenario));
    }
    require_one_covariance(point.scenario, options.scenario);
    require_path(point.scenario, options.scenario);
  }
  require_no_option_of_others(options, false);
  const bool swept = std::ranges::find(plan.axes, "filter.solution", &SweepAxis::path) != plan.axes.end();
  const FollowedSolutions which = swept ? FollowedSolutions::own : FollowedSolutions::all;
  std::vector<PlanarStability> analyses(plan.points.size());
  ProgressDisplay display(plan.name, options.quiet, "configurations");
  StudyProgress progress{.runs_total = static_cast<std::int64_t>(plan.points.size())};
  std::mutex mutex;
  for_each_task(progress.runs_total, options.threads, &catch_interrupt(), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    analyses[at] = analyse_planar_stability(plan.points[at].scenario, options.loops, which);
    const std::lock_guard lock(mutex);
    ++progress.runs_done;
    display.show(progress);
  });
  stop_point();
  return analyses;
}

/// Of a linear world, a planar one, or a sweep over planar ones.
Document stability_of(const SweepPlan& plan, const StabilityOptions& options) {
  if (!plan.axes.empty()) return planar_table_document(plan, analyse_points(plan, options));
  const Scenario& scenario = plan.points.front().scenario;
  const std::optional<LinearProblem> linear = linear_problem(scenario);
  require_one_covariance(scenario, options.scenario);
  if (!linear) require_path(scenario, options.scenario);
  require_no_option_of_others(options, linear.has_value());
  if (linear) return linear_stability(scenario, *linear, options);
  return planar_stability_document(scenario, analyse_planar_stability(scenario, options.loops));
}

int stability(const StabilityOptions& options) {
  const SweepPlan plan = open_sweep(options.scenario, options.overrides());
  tell_of_stop_rule(plan.points.front().scenario, "stability");
  const bool shows_points = !plan.axes.empty();
  const StopScope stop(&catch_interrupt());
  const StepDisplay display(plan.name, options.quiet || shows_points, "steps");
  tell(naming_file(options.scenario, [&] { return stability_of(plan, options); }), options);
  return kDone;
}

}  // namespace

void add_stability_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "stability", "does P stay bounded? ranks, eigenvalues, Riccati equation, predicted and measured");
  auto options = std::make_shared<StabilityOptions>();
  options->command = command;
  command->add_option("scenario", options->scenario, "scenario file, or a name of credence list")->required();
  add_setting_option(*command, *options);
  add_study_option(*command, "steps", "steps of the study", options->steps);
  add_study_option(*command, "seed", "of the noisy run of a planar world", options->seed);
  add_threads_option(*command, options->threads);
  add_output_options(*command, *options);
  command
      ->add_option("--horizon", options->horizon,
                   "linear worlds: steps of the long run; no fewer than those of the study are made")
      ->check(CLI::Range(Index{4}, Index{10'000'000}))
      ->capture_default_str();
  command->add_option("--loops", options->loops, "planar worlds: how often the path is driven")
      ->check(CLI::Range(Index{4}, Index{100'000}))
      ->capture_default_str();
  static constexpr const char* kExamples[] = {
      "credence stability figure2_two_landmarks", "credence stability figure3_two_landmarks --format json",
      "credence stability figure3_two_landmarks --set world.landmarks=6 --out out/stability",
      "credence stability planar_stability --set filter.inflation=full",
      "credence stability planar_table --out out/planar_table"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] { throw ExitStatus{stability(*options)}; });
}

}  // namespace credence::internal
