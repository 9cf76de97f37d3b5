#include <algorithm>

#include "core/nan.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/best_time.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/linear/linear_estimator_experiment.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/linear/linear_keys.h"
#include "montecarlo/worlds/linear/linear_world.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {
namespace {

class LinearContest final : public EstimatorContest {
 public:
  explicit LinearContest(const Scenario& scenario) : scenario_(scenario), truth_(linear_truth(scenario)) {}

  Index steps() const override { return scenario_.study.steps; }
  std::unique_ptr<EstimatorPlayer> player(std::span<const std::string> names) const override {
    auto player = std::make_unique<Player>();
    for (const std::string& name : names) player->experiments.push_back(experiment(name));
    return player;
  }

  EstimatorProfile profile(std::string_view name, const TakeRow& take_row) const override {
    const auto of_name = experiment(name);
    std::int64_t played = 0;  // a filter may fail
    const double seconds =
        best_time(3, [&] { of_name->visit(0, [&](const TraceStep& shown) { played = shown.step; }); });
    Matrix transition = Matrix::Identity(unknowns(), unknowns());  // Fᵏ, or F_k … F_1
    for (Index k = 1; k <= unknowns() * std::ssize(truth_); ++k) {
      const Matrix rows = model_at(truth_, k).H * transition;
      for (Index r = 0; r < rows.rows(); ++r) take_row(Vector(rows.row(r).transpose()));
      transition = model_at(truth_, k + 1).F * transition;
    }
    return {.known = unknowns(), .seconds_per_step = seconds / static_cast<double>(played)};
  }

  Index unknowns() const override { return truth_.front().state_dim(); }

  /// P of the Kalman filter that knows the noise and which measurements are missed, whose error reaches the
  /// bound; of runs that miss different ones their mean.
  VehicleBound bound() const override {
    LinearProblem knowing = linear_world_problem(scenario_);
    knowing.assumed = knowing.truth;
    knowing.assumed_later = knowing.truth_later;
    knowing.rule = {};
    const std::int64_t runs =
        knowing.detection_probability < 1.0 ? std::min(kBoundRuns, scenario_.study.runs) : 1;
    const auto filter = make_linear_experiment(std::move(knowing), steps(), noise_source(scenario_));
    double sum = 0.0;
    for (std::int64_t r = 0; r < runs; ++r) {
      const Outcome outcome = filter->visit(r, [&](const TraceStep& shown) {
        if (shown.step > 0) sum += shown.P.trace();
      });
      if (outcome != Outcome::ok) return {.heading_squared = kNaN, .position_squared = kNaN};
    }
    return {.heading_squared = kNaN, .position_squared = sum / static_cast<double>(runs * steps())};
  }

  bool has_vehicle() const override { return false; }
  std::string note() const override {
    return "NEES: of the whole state. RMSE: the root of the summed squared errors of all states, each in its "
           "unit. The bound is that of filters, which a smoother passes. Time a step: a run with the gains "
           "at hand.";
  }

 private:
  struct Player final : EstimatorPlayer {
    void play(std::int64_t run, EstimatorListener& listener) override {
      for (std::size_t e = 0; e < experiments.size(); ++e) {
        bool heard = true;
        experiments[e]->visit(run, [&](const TraceStep& shown) {
          if (shown.step == 0 || !heard) return;
          if (shown.outcome != Outcome::ok) return listener.failed(e, shown.step, shown.outcome);
          EstimatorStep step;
          step[EstimatorBlock::pose] = {shown.nees, shown.nees_dof};
          step.position_squared = shown.error.squaredNorm();
          step.position_variance = shown.P.trace();
          heard = listener.take(e, shown.step, step);
        });
      }
    }
    std::vector<std::unique_ptr<Experiment>> experiments;
  };

  std::unique_ptr<Experiment> experiment(std::string_view name) const {
    return linear_estimator_experiment(scenario_, name);
  }

  Scenario scenario_;
  std::vector<LinearModel> truth_;  ///< of a period
};

std::unique_ptr<EstimatorContest> linear_contest(const Scenario& scenario) {
  return std::make_unique<LinearContest>(scenario);
}

}  // namespace

constinit const EstimatorOffer kLinearOffer = {.names = linear_estimator_names, .contest = linear_contest};

}  // namespace credence::internal
