#include "analysis/tuning/scenario_noise.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "analysis/tuning/filter_score.h"
#include "analysis/tuning/linear_score.h"
#include "core/models/model_mismatch.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

/// Sets a key from an array of rows.
void set_rows(Scenario& scenario, std::string_view section, std::string_view name, const Matrix& matrix) {
  NestedArray rows;
  for (Index i = 0; i < matrix.rows(); ++i) {
    auto& row = rows.emplace_back();
    for (Index j = 0; j < matrix.cols(); ++j) row.emplace_back(matrix(i, j));
  }
  set_key(*find_scenario_key(section, name), rows, scenario);
}

bool has_key(const Scenario& scenario, std::string_view name) {
  const ScenarioKey* const key = find_scenario_key("filter", name);
  return key != nullptr && key->of_world(scenario.world.model);
}

/// Refuses what has no key in this world.
void require_keys(const Scenario& scenario, const std::vector<FreeNoise>& free) {
  for (const FreeNoise& noise : free) {
    if (noise.form == NoiseForm::factor && noise.matrix != NoiseMatrix::P0) continue;
    if (has_key(scenario, to_string(noise.matrix))) continue;
    throw std::invalid_argument(
        fmt::format("world.model = \"{}\" has no filter.{}: only the factors Q and R can be tuned there",
                    scenario.world.model, to_string(noise.matrix)));
  }
}

/// What the world's sensor gives in each of the study's runs, with the filter's start.
std::vector<MeasuredRun> measure_runs(const Scenario& scenario, LinearProblem problem, int threads,
                                      const std::atomic<bool>* stop) {
  const auto runs = scenario.study.runs;
  const double doubles = static_cast<double>(runs) * static_cast<double>(scenario.study.steps) *
                         static_cast<double>(problem.truth.measurement_dim());
  if (doubles > kMostDoubles) {
    throw std::invalid_argument(
        fmt::format("study.runs = {} and study.steps = {} are more measurements than are kept; fewer runs "
                    "say as much",
                    runs, scenario.study.steps));
  }
  require_exact_differences(problem, scenario.study.steps);
  // Of a filter that is right: one that is not may fail where the world does not.
  problem.assumed = problem.truth;
  const auto experiment =
      make_linear_experiment(std::move(problem), scenario.study.steps, noise_source(scenario));
  std::vector<MeasuredRun> measured(static_cast<std::size_t>(runs));
  for_each_task(runs, threads, stop, [&](std::int64_t i) {
    MeasuredRun& run = measured[static_cast<std::size_t>(i)];
    const Outcome outcome = experiment->visit(i, [&](const TraceStep& step) {
      if (step.step == 0) {
        run.start = step.estimate;
        return;
      }
      if (run.z.size() == 0) run.z.resize(step.z.size(), scenario.study.steps);
      run.z.col(step.step - 1) = step.z;
    });
    if (outcome != Outcome::ok) {
      throw std::invalid_argument("no filter can score this world: the true S is not positive definite");
    }
  });
  if (stop != nullptr && stop->load()) throw Stopped{};
  return measured;
}

class LinearScenarioScore final : public ScenarioScore {
 public:
  LinearScenarioScore(const Scenario& scenario, const LinearProblem& problem,
                      const std::vector<FreeNoise>& free, int threads, const std::atomic<bool>* stop,
                      const PlayCount::Watch& watch)
      : scenario_(scenario),
        score_(NoiseParameters(problem.assumed, free), measure_runs(scenario, problem, threads, stop),
               threads, stop) {
    score_.watch(watch);
  }

  const ScoreModel& model() const override { return score_; }
  Vector start() const override { return score_.noise().start(); }
  std::string engine() const override { return "linear filter, exact gradient"; }

  Scenario scenario_at(const Vector& phi) const override {
    const NoiseParameters& noise = score_.noise();
    const LinearModel model = noise.at(phi);
    Scenario tuned = scenario_;
    for (const FreeNoise& free : noise.free()) {
      const bool factor = free.form == NoiseForm::factor;
      if (free.matrix == NoiseMatrix::P0) {
        set_rows(tuned, "filter", "P0", model.P0);
      } else if (free.matrix == NoiseMatrix::Q) {
        tuned.filter.process_scale *= factor ? model.Q.norm() / noise.model().Q.norm() : 1.0;
        if (!factor) set_rows(tuned, "filter", "Q", model.Q / tuned.filter.process_scale);
      } else {
        tuned.filter.measurement_scale *= factor ? model.R.norm() / noise.model().R.norm() : 1.0;
        if (!factor) set_rows(tuned, "filter", "R", model.R / tuned.filter.measurement_scale);
      }
    }
    return tuned;
  }

  Key key(const std::string& parameter) const override {
    if (parameter == "Q") return {"filter.process_scale", scenario_.filter.process_scale};
    if (parameter == "R") return {"filter.measurement_scale", scenario_.filter.measurement_scale};
    if (parameter == "P0") return {"factor of filter.P0", 1.0};
    if (parameter.starts_with("L_")) return {parameter, 1.0};
    const double scale = parameter.starts_with("Q[")   ? scenario_.filter.process_scale
                         : parameter.starts_with("R[") ? scenario_.filter.measurement_scale
                                                       : 1.0;
    return {"filter." + parameter, 1.0 / scale};  // the scale is applied to the matrix of the key
  }

  void forget_stop() override { score_.forget_stop(); }

 private:
  Scenario scenario_;
  LinearScore score_;
};

/// Any other filter of a scenario: process_scale and measurement_scale as factors of a black box.
class PlayedScenarioScore final : public ScenarioScore {
 public:
  PlayedScenarioScore(const Scenario& scenario, const std::vector<FreeNoise>& free, int threads,
                      const std::atomic<bool>* stop, const PlayCount::Watch& watch)
      : scenario_(scenario), free_(free) {
    std::vector<FilterFactor> factors;
    for (const FreeNoise& noise : free_) {
      if (noise.form != NoiseForm::factor || noise.matrix == NoiseMatrix::P0) {
        throw std::invalid_argument(fmt::format(
            "{}: of a filter that inflates, misses measurements or is not linear only the factors Q and R "
            "can be tuned",
            to_string(noise.matrix)));
      }
      factors.push_back({std::string(to_string(noise.matrix)), 1.0});
    }
    score_ = std::make_unique<FilterScore>(
        std::move(factors),
        [this](const std::vector<double>& values) { return make_experiment(scaled(values)); },
        scenario_.study.runs, threads, stop);
    score_->watch(watch);
  }

  const ScoreModel& model() const override { return *score_; }
  Vector start() const override { return Vector::Zero(score_->parameters()); }
  std::string engine() const override { return "filter as a black box, common random numbers"; }

  Scenario scenario_at(const Vector& phi) const override {
    std::vector<double> values;
    for (const double x : phi) values.push_back(std::exp(x));
    return scaled(values);
  }

  Key key(const std::string& parameter) const override {
    if (parameter == "Q") return {"filter.process_scale", scenario_.filter.process_scale};
    return {"filter.measurement_scale", scenario_.filter.measurement_scale};
  }

  void forget_stop() override { score_->forget_stop(); }

 private:
  Scenario scaled(const std::vector<double>& values) const {
    Scenario scenario = scenario_;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      (free_[i].matrix == NoiseMatrix::Q ? scenario.filter.process_scale
                                         : scenario.filter.measurement_scale) *= values[i];
    }
    return scenario;
  }

  Scenario scenario_;
  std::vector<FreeNoise> free_;
  std::unique_ptr<FilterScore> score_;
};

}  // namespace

std::unique_ptr<ScenarioScore> make_scenario_score(const Scenario& scenario,
                                                   const std::vector<FreeNoise>& free, int threads,
                                                   const std::atomic<bool>* stop,
                                                   const PlayCount::Watch& watch) {
  require_keys(scenario, free);
  const std::optional<LinearProblem> linear = linear_problem(scenario);
  if (linear && !linear->is_periodic() && scenario.noise.detection_probability == 1.0 &&
      linear->measurement_delay == 0 && scenario.filter.inflation == FilterInflation::none) {
    return std::make_unique<LinearScenarioScore>(scenario, *linear, free, threads, stop, watch);
  }
  return std::make_unique<PlayedScenarioScore>(scenario, free, threads, stop, watch);
}

}  // namespace credence::internal
