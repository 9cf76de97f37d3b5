#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/stop_point.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/worlds/plugged/plug_check.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"
#include "montecarlo/worlds/plugged/plugged_statistics.h"

namespace credence {

/// How a plugged study is run.
struct PlugSettings {
  std::int64_t steps = 100;
  std::uint64_t seed = 1;
  std::uint64_t noise_group = 0;  ///< studies of one seed and group meet the same noise
};

/// Many runs of a user's filter in a user's world. `make_filter()` gives a fresh filter and must be safe to
/// call from several threads.
template <PluggedWorld World, class MakeFilter>
requires PluggedFilter<std::invoke_result_t<const MakeFilter&>, World>
class PluggedExperiment final : public Experiment {
 public:
  using Filter = std::invoke_result_t<const MakeFilter&>;
  using State = StateOf<World>;

  PluggedExperiment(World world, MakeFilter make_filter, const PlugSettings& settings = {})
      : Experiment(layout_of(world, make_filter, NoiseSource(settings.seed, settings.noise_group))),
        world_(std::move(world)),
        make_filter_(std::move(make_filter)),
        steps_(settings.steps),
        source_(settings.seed, settings.noise_group) {}

  std::int64_t steps() const { return steps_; }

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override {
    return visited_chunk(*this, steps_, first_run, runs);
  }

  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    Run play(*this, run);
    return play.visit(take);
  }

  RunTrace describe_world() const override { return {}; }

  /// What the filter, or the world, said when it threw in this run; empty where it did not.
  std::string said(std::int64_t run) const {
    Run play(*this, run);
    play.visit([](const TraceStep&) {});
    return play.said();
  }

  /// What is wrong with the plug, as far as a few runs show; empty if nothing.
  std::vector<std::string> problems() const {
    std::vector<std::string> found = plug_problems(*this);
    if constexpr (requires(const World& w, const State& x, const Vector& d) { w.plus(x, d); }) {
      check_plus(found);
    }
    if constexpr (requires(const Filter& f) { std::optional<std::string>(f.jacobian_problem()); }) {
      Run play(*this, 0);
      std::optional<std::string> problem;
      play.visit([&](const TraceStep&) {
        if (!problem) problem = play.filter().jacobian_problem();
      });
      if (problem) found.push_back(*problem);
    }
    return found;
  }

 private:
  static constexpr std::int64_t kInputSlots = std::int64_t{1} << 20;  ///< beyond those of the process noise

  /// One run on its way.
  class Run {
   public:
    Run(const PluggedExperiment& experiment, std::int64_t run)
        : e_(experiment), run_(run), filter_(e_.make_filter_()), truth_(e_.world_.prior().mean) {}

    Outcome visit(const StepVisitor& take) {
      if (!guarded([&] { start(); })) {
        TraceStep failed;
        failed.step = 1;
        failed.outcome = Outcome::threw;
        take(failed);
        return Outcome::threw;
      }
      take(shown_);
      for (std::int64_t k = 1; k <= e_.steps_; ++k) {
        stop_point();
        Outcome outcome = Outcome::ok;
        if (!guarded([&] { outcome = step(k); })) outcome = Outcome::threw;
        shown_.step = k;
        shown_.outcome = outcome;
        if (outcome != Outcome::ok) shown_.nees_dof = shown_.nis_dof = 0;
        take(shown_);
        if (outcome != Outcome::ok) return outcome;
      }
      return Outcome::ok;
    }

    const Filter& filter() const { return filter_; }
    const std::string& said() const { return said_; }

   private:
    template <class Action>
    bool guarded(const Action& action) {
      try {
        action();
        return true;
      } catch (const Stopped&) {
        throw;
      } catch (const std::exception& error) {
        said_ = error.what();
      } catch (...) {
        said_ = "an exception that is no std::exception";
      }
      return false;
    }

    NoiseDraw noise(std::int64_t k, NoisePurpose purpose, std::int64_t slot = 0) const {
      return {e_.source_, run_, k, purpose, slot};
    }

    void start() {
      NoiseDraw draw = noise(0, NoisePurpose::initial);
      truth_ = e_.world_.initial(draw);
      const auto prior = e_.world_.prior();
      filter_.reset(prior.mean, prior.covariance);
      show(false);
    }

    Outcome step(std::int64_t k) {
      NoiseDraw process = noise(k, NoisePurpose::process);
      truth_ = e_.world_.step(truth_, k, process);
      if constexpr (HasInput<World>) {
        NoiseDraw input = noise(k, NoisePurpose::process, kInputSlots);
        filter_.predict(e_.world_.input(truth_, k, input));
      } else {
        filter_.predict();
      }
      NoiseDraw measurement = noise(k, NoisePurpose::measurement);
      const auto z = e_.world_.measure(truth_, k, measurement);
      bool measured = true;
      if constexpr (plugged::IsOptional<std::decay_t<decltype(z)>>::value) measured = z.has_value();
      if (measured && !update(plugged::value_of(z))) return Outcome::not_positive_definite;
      return show(measured);
    }

    template <class Measurement>
    bool update(const Measurement& z) {
      if constexpr (std::is_convertible_v<decltype(filter_.update(z)), bool>) {
        return filter_.update(z);
      } else {
        filter_.update(z);
        return true;
      }
    }

    Outcome show(bool measured) {
      const State& estimate = filter_.state();
      shown_.error = state_minus(e_.world_, estimate, truth_);
      shown_.P = filter_.covariance();
      if (measured) {
        shown_.innovations = innovations_of(filter_);
      } else {
        shown_.innovations.assign(e_.layout().sensors.size(), {});
      }
      if constexpr (std::is_convertible_v<const State&, Vector>) {
        shown_.truth = truth_;
        shown_.estimate = estimate;
      } else if constexpr (requires { Vector(e_.world_.coordinates(truth_)); }) {
        shown_.truth = e_.world_.coordinates(truth_);
        shown_.estimate = shown_.truth + shown_.error;
      }
      if (shown_.states.empty()) {
        for (Index i = 0; i < std::ssize(e_.layout().states); ++i) shown_.states.push_back(i);
      }
      require_fit(e_.layout(), shown_);
      if (!shown_.error.allFinite() || !shown_.P.allFinite()) return Outcome::diverged;
      normalise_step(shown_);
      return Outcome::ok;
    }

    const PluggedExperiment& e_;
    std::int64_t run_;
    Filter filter_;
    State truth_;
    TraceStep shown_;
    std::string said_;
  };

  /// That of the world, or else with plain names and the innovations of the first update of run 0.
  static RunLayout layout_of(const World& world, const MakeFilter& make_filter, const NoiseSource& source) {
    if constexpr (requires { RunLayout(world.layout()); }) {
      return world.layout();
    } else {
      const auto prior = world.prior();
      std::vector<std::string> names;
      const Index n = state_minus(world, prior.mean, prior.mean).size();
      for (Index i = 1; i <= n; ++i) names.emplace_back("x").append(std::to_string(i));
      return model_layout(names, first_sensors(world, make_filter(), source));
    }
  }

  static std::vector<std::pair<std::string, Index>> first_sensors(const World& world, Filter filter,
                                                                  const NoiseSource& source) {
    std::vector<std::pair<std::string, Index>> sensors;
    try {
      NoiseDraw initial(source, 0, 0, NoisePurpose::initial), process(source, 0, 1, NoisePurpose::process),
          measurement(source, 0, 1, NoisePurpose::measurement);
      const auto prior = world.prior();
      filter.reset(prior.mean, prior.covariance);
      const State truth = world.step(world.initial(initial), 1, process);
      if constexpr (HasInput<World>) {
        NoiseDraw input(source, 0, 1, NoisePurpose::process, kInputSlots);
        filter.predict(world.input(truth, 1, input));
      } else {
        filter.predict();
      }
      const auto z = world.measure(truth, 1, measurement);
      if constexpr (plugged::IsOptional<std::decay_t<decltype(z)>>::value) {
        if (!z) throw std::invalid_argument("the first step measures nothing: give the world a layout()");
      }
      filter.update(plugged::value_of(z));
    } catch (const std::invalid_argument&) {
      throw;
    } catch (const std::exception&) {
      return sensors;  // a failure of run 0, which will be counted
    }
    const std::vector<Innovation> innovations = innovations_of(filter);
    for (std::size_t i = 0; i < innovations.size(); ++i) {
      std::string name;
      if (innovations.size() > 1) name.append("sensor ").append(std::to_string(i + 1));
      sensors.emplace_back(std::move(name), innovations[i].nu.size());
    }
    return sensors;
  }

  /// minus(plus(x, d), x) = d for small d.
  void check_plus(std::vector<std::string>& found) const {
    const State x = world_.prior().mean;
    NoiseDraw draw(source_, 0, 0, NoisePurpose::decision);
    const Vector d = 1e-2 * draw.normals(std::ssize(layout().states));
    report_plus(d, state_minus(world_, State(world_.plus(x, d)), x), found);
  }

  World world_;
  MakeFilter make_filter_;
  std::int64_t steps_;
  NoiseSource source_;
};

}  // namespace credence
