#include "analysis/tuning/tune_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/stop_point.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

constexpr double kPower = 0.8;

/// The first coordinate of a covariance, by the names of the coordinates.
std::optional<Index> coordinate_of(const ScoreModel& model, std::string_view matrix) {
  const std::vector<std::string> names = model.names();
  const auto found = std::ranges::find_if(names, [&](const std::string& name) {
    return name == matrix || name.starts_with(fmt::format("{}[", matrix));
  });
  if (found == names.end()) return std::nullopt;
  return found - names.begin();
}

bool was_found(const Tuning& tuning, Index coordinate) {
  return std::ranges::find(tuning.estimate.free, coordinate) != tuning.estimate.free.end();
}

void add_ridge(ScenarioTuning& all) {
  const ScoreModel& model = all.score->model();
  const auto Q = coordinate_of(model, "Q"), R = coordinate_of(model, "R");
  if (!Q || !R || !was_found(all.tuning, *Q) || !was_found(all.tuning, *R)) return;
  all.ridge_of = {*Q, *R};
  std::vector<double> shifts;
  for (const double factor : {0.1, 0.3, 3.0, 10.0}) shifts.push_back(std::log(factor));
  all.ridge = nis_ridge(model, all.tuning, *Q, *R, shifts);
}

/// Parameters by their keys, and values in the unit of these.
void name_by_keys(const ScenarioScore& score, Tuning& tuning) {
  for (TunedParameter& parameter : tuning.parameters) {
    const ScenarioScore::Key key = score.key(parameter.name);
    parameter.name = key.name;
    for (double* number : {&parameter.before, &parameter.value, &parameter.lower, &parameter.upper,
                           &parameter.bootstrap_lower, &parameter.bootstrap_upper}) {
      *number *= key.unit;
    }
  }
  for (std::string& name : tuning.coordinates) name = score.key(name).name;
  for (TuningForecast::Parameter& parameter : tuning.forecast.parameters) {
    parameter.name = score.key(parameter.name).name;
  }
}

/// `first`: runs that were played before, of twice as many as these.
StudyAnalysis judge_again(const Scenario& scenario, std::int64_t first, const TuneRequest& request) {
  EngineOptions options;
  options.threads = request.threads;
  options.stop = request.stop;
  const auto experiment = make_experiment(scenario);
  const std::int64_t runs = scenario.study.runs;
  EvidenceCollector evidence(*experiment, evidence_runs(scenario, runs));
  StudyTask task{.id = "", .experiment = experiment.get(), .runs = runs};
  task.play = [&](std::int64_t first, std::int64_t count) { return evidence.play(first, count); };
  if (request.progress) {
    options.progress = [&](StudyProgress progress) {
      progress.runs_done += first;
      progress.runs_total *= 2;
      request.progress(progress);
    };
  }
  StudyResult result = std::move(run_studies(std::span(&task, 1), options).front());
  StudyAnalysis analysis = analyse_study(scenario, *experiment, std::move(result));
  options.progress = {};
  if (analysis.complete) add_judgement(analysis, evidence, options);
  return analysis;
}

Scenario with_fresh_noise(Scenario scenario) {
  constexpr auto kLargestSeed = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  scenario.study.seed = scenario.study.seed == kLargestSeed ? 0 : scenario.study.seed + 1;
  scenario.stop = {};
  return scenario;
}

HeldOut hold_out(const ScenarioTuning& all, const TuneRequest& request) {
  HeldOut held_out{.before = judge_again(with_fresh_noise(all.scenario), 0, request),
                   .after = judge_again(with_fresh_noise(all.tuned), all.scenario.study.runs, request)};
  const VerdictDesign design{.steps = static_cast<double>(all.scenario.study.steps),
                             .dof_per_step = held_out.after.nis.expected,
                             .confidence = all.scenario.study.confidence,
                             .white = true};
  if (!std::isfinite(design.dof_per_step)) return held_out;  // interrupted, or every run failed at once
  held_out.detectable = detectable_factors(design, static_cast<double>(all.scenario.study.runs), kPower);
  return held_out;
}

}  // namespace

std::optional<ScenarioTuning> tune_scenario(const Scenario& scenario, const TuneRequest& request) {
  const auto stopped = [&] { return request.stop != nullptr && request.stop->load(); };
  ScenarioTuning all{.scenario = scenario, .tuned = scenario};
  const StopScope scope(request.stop);
  try {
    all.score = make_scenario_score(scenario, request.free, request.threads, request.stop, request.watch);
    all.tuning = tune(all.score->model(), all.score->start(), scenario.study.confidence);
    if (all.tuning.anything_known()) {
      add_ridge(all);
      all.tuned = all.score->scenario_at(all.tuning.phi);
      all.held_out = hold_out(all, request);
    }
  } catch (const Stopped&) {
    return std::nullopt;
  }
  if (stopped()) return std::nullopt;
  name_by_keys(*all.score, all.tuning);
  return all;
}

}  // namespace credence::internal
