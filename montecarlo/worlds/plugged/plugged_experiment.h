#pragma once

#include <algorithm>
#include <array>
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
#include "montecarlo/random/delay_line.h"
#include "montecarlo/worlds/plugged/plug_check.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"
#include "montecarlo/worlds/plugged/plugged_statistics.h"

namespace credence::internal {

namespace plugged {

inline constexpr std::int64_t kInputSlots = std::int64_t{1} << 20;  ///< beyond those of the process noise

/// A measurement as numbers; empty where it is no vector.
template <class Measurement>
Vector vector_of(const Measurement& z) {
  if constexpr (std::is_convertible_v<const Measurement&, Vector>) {
    return z;
  } else if constexpr (std::is_convertible_v<const Measurement&, double>) {
    return Vector::Constant(1, z);
  } else {
    return {};
  }
}

/// What an action threw; nothing where it did not. A stop goes on.
template <class Action>
std::optional<PlugThrown> thrown_by(const Action& action) {
  try {
    action();
    return std::nullopt;
  } catch (const Stopped&) {
    throw;
  } catch (const PlugMisfit& error) {
    return PlugThrown{error.what(), true};
  } catch (const std::exception& error) {
    return PlugThrown{error.what()};
  } catch (...) {
    return PlugThrown{"an exception that is no std::exception"};
  }
}

/// Puts what a filter shows after a step beside the truth; `diverged` where it is not finite. `chosen`: it
/// has the states of the layout that are in `shown`, in their order, and not all of them.
template <class World>
Outcome show(const World& world, const RunLayout& layout, const StateOf<World>& truth,
             const StateOf<World>& estimate, Matrix P, std::vector<Innovation> innovations, TraceStep& shown,
             bool chosen = false) {
  constexpr bool kVector = std::is_convertible_v<const StateOf<World>&, Vector>;
  if constexpr (
      kVector && !requires { Vector(world.minus(estimate, truth)); } &&
      !requires { Vector(minus(estimate, truth)); }) {
    const Vector all = truth, x = estimate;
    require_size(x.size(), chosen ? std::ssize(shown.states) : all.size());
    shown.error = chosen ? Vector(x - all(shown.states)) : Vector(x - all);
  } else {
    shown.error = state_minus(world, estimate, truth);
  }
  shown.P = std::move(P);
  shown.innovations = std::move(innovations);
  if constexpr (kVector) {
    shown.truth = truth;
    if (chosen) shown.truth = Vector(shown.truth(shown.states));
    shown.estimate = estimate;
  } else if constexpr (requires { Vector(world.coordinates(truth)); }) {
    shown.truth = world.coordinates(truth);
    shown.estimate = shown.truth + shown.error;
  }
  if (!chosen && shown.states.empty()) {
    for (Index i = 0; i < std::ssize(layout.states); ++i) shown.states.push_back(i);
  }
  require_fit(layout, shown);
  if (!shown.error.allFinite() || !shown.P.allFinite()) return Outcome::diverged;
  normalise_step(shown);
  return Outcome::ok;
}

}  // namespace plugged

}  // namespace credence::internal

namespace credence {

/// How a plugged study is run.
struct PlugSettings {
  std::int64_t steps = 100;
  std::uint64_t seed = 1;
  std::uint64_t noise_group = 0;   ///< studies of one seed and group meet the same noise
  NoiseShape process_shape{};      ///< of the world's step and input; plain: white and Gaussian
  NoiseShape measurement_shape{};  ///< of what the world's measure draws
  Index measurement_delay = 0;     ///< steps after which a measurement reaches the filter

  NoiseSource source() const {
    return NoiseSource(seed, noise_group).shaped(process_shape, measurement_shape);
  }
};

/// Many runs of a user's filter in a user's world. `make_filter()` gives a fresh filter and must be safe to
/// call from several threads.
template <PluggedWorld World, class MakeFilter>
requires PluggedFilter<std::invoke_result_t<const MakeFilter&>, World>
class PluggedExperiment final : public internal::VisitedExperiment {
 public:
  using Filter = std::invoke_result_t<const MakeFilter&>;
  using State = internal::StateOf<World>;
  using Measured = std::decay_t<decltype(std::declval<const World&>().measure(
      std::declval<const State&>(), std::int64_t{}, std::declval<NoiseDraw&>()))>;

  PluggedExperiment(World world, MakeFilter make_filter, const PlugSettings& settings = {})
      : internal::VisitedExperiment(layout_of(world, make_filter, settings.source()), settings.steps),
        world_(std::move(world)),
        make_filter_(std::move(make_filter)),
        delay_(settings.measurement_delay),
        source_(settings.source()) {}

  Outcome visit(std::int64_t run, const StepVisitor& take) const override {
    Run play(*this, run);
    return play.visit(take);
  }

  RunTrace describe_world() const override { return {}; }

  /// What the filter, or the world, said when it threw in this run; empty where it did not.
  std::string said(std::int64_t run) const { return thrown_in(run).said; }

  /// What is wrong with the plug, as far as a few runs show; empty if nothing.
  std::vector<std::string> problems() const {
    std::vector<std::string> found =
        internal::plug_problems(*this, [this](std::int64_t run) { return thrown_in(run); });
    if (found.empty()) check_side_by_side(found);
    if constexpr (requires(const World& w, const State& x, const Vector& d) { w.plus(x, d); }) {
      if (found.empty()) check_plus(found);
    }
    if constexpr (internal::HasTimeStep<World>) check_time_step(found);
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
  /// One run on its way.
  class Run {
   public:
    Run(const PluggedExperiment& experiment, std::int64_t run)
        : e_(experiment),
          run_(run),
          filter_(e_.make_filter_()),
          truth_(e_.world_.prior().mean),
          line_(e_.delay_) {}

    Outcome visit(const StepVisitor& take) {
      for (std::int64_t k = 0; k <= e_.steps(); ++k) {
        if (k > 0) internal::stop_point();
        take(advance(k));
        if (shown_.outcome != Outcome::ok) return shown_.outcome;
      }
      return Outcome::ok;
    }

    /// Step k after k − 1; 0: the start, which fails as step 1. What it shows is good until the next one.
    const TraceStep& advance(std::int64_t k) {
      Outcome outcome = Outcome::ok;
      const bool well = guarded([&] {
        if (k == 0) {
          start();
        } else {
          outcome = step(k);
        }
      });
      if (!well) outcome = Outcome::threw;
      if (k == 0 && !well) shown_ = TraceStep();
      if (k > 0 || !well) shown_.step = std::max<std::int64_t>(k, 1);
      shown_.outcome = outcome;
      if (outcome != Outcome::ok) shown_.nees_dof = shown_.nis_dof = 0;
      return shown_;
    }

    const Filter& filter() const { return filter_; }
    const internal::PlugThrown& thrown() const { return thrown_; }

   private:
    template <class Action>
    bool guarded(const Action& action) {
      std::optional<internal::PlugThrown> thrown = internal::plugged::thrown_by(action);
      if (thrown) thrown_ = std::move(*thrown);
      return !thrown;
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
      NoiseDraw input = noise(k, NoisePurpose::process, internal::plugged::kInputSlots);
      internal::plugged::predict(filter_, e_.world_, internal::plugged::input_of(e_.world_, truth_, k, input),
                                 1.0);
      NoiseDraw measurement = noise(k, NoisePurpose::measurement);
      const std::optional<Measured> z = line_.pass(e_.world_.measure(truth_, k, measurement));
      bool measured = z.has_value();
      if constexpr (internal::plugged::IsOptional<Measured>::value) measured = measured && z->has_value();
      shown_.z = measured ? internal::plugged::vector_of(internal::plugged::value_of(*z)) : Vector();
      if (measured && !update(internal::plugged::value_of(*z))) return Outcome::not_positive_definite;
      return show(measured);
    }

    template <class Measurement>
    bool update(const Measurement& z) {
      using Told = decltype(filter_.update(z));
      static_assert(std::is_same_v<Told, bool> || !std::is_convertible_v<Told, bool>,
                    "update(z) of the filter must give a bool, false where it fails, or nothing");
      if constexpr (std::is_same_v<Told, bool>) {
        return filter_.update(z);
      } else {
        filter_.update(z);
        return true;
      }
    }

    Outcome show(bool measured) {
      std::vector<Innovation> innovations(e_.layout().sensors.size());
      if constexpr (internal::HasStates<Filter>) {
        const auto& states = std::as_const(filter_).states();
        shown_.states.assign(states.begin(), states.end());
        internal::require_states(e_.layout(), shown_.states);
      }
      if (measured) innovations = internal::innovations_of(filter_);
      return internal::plugged::show(e_.world_, e_.layout(), truth_, filter_.state(), filter_.covariance(),
                                     std::move(innovations), shown_, internal::HasStates<Filter>);
    }

    const PluggedExperiment& e_;
    std::int64_t run_;
    Filter filter_;
    State truth_;
    internal::DelayLine<Measured> line_;
    TraceStep shown_;
    internal::PlugThrown thrown_;
  };

  /// That of the world, or else with plain names and the innovations of the first update of run 0.
  static RunLayout layout_of(const World& world, const MakeFilter& make_filter, const NoiseSource& source) {
    if constexpr (requires { RunLayout(world.layout()); }) {
      RunLayout layout = internal::completed(world.layout());
      if (!internal::kShowsInnovations<Filter>) layout.sensors.clear();  // nothing will be heard of them
      return layout;
    } else {
      static_assert(!internal::HasStates<Filter>,
                    "a filter with states() needs a world with layout(), which says what all of them are");
      const auto prior = world.prior();
      std::vector<std::string> names;
      const Index n = internal::state_minus(world, prior.mean, prior.mean).size();
      for (Index i = 1; i <= n; ++i) names.emplace_back("x").append(std::to_string(i));
      return internal::model_layout(names, first_sensors(world, make_filter, source));
    }
  }

  /// Those of the first of a few runs that does not fail at its first step; none where all do.
  static std::vector<std::pair<std::string, Index>> first_sensors(const World& world,
                                                                  const MakeFilter& make_filter,
                                                                  const NoiseSource& source) {
    constexpr std::int64_t kRunsTried = 64;
    std::exception_ptr misfit;
    for (std::int64_t run = 0; run < kRunsTried; ++run) {
      try {
        return sensors_of(after_first_step(world, make_filter(), source, run));
      } catch (const internal::Stopped&) {
        throw;
      } catch (const std::invalid_argument&) {
        misfit = std::current_exception();
      } catch (...) {
        continue;  // a failure of this run, which will be counted
      }
    }
    if (misfit) std::rethrow_exception(misfit);
    return {};
  }

  static Filter after_first_step(const World& world, Filter filter, const NoiseSource& source,
                                 std::int64_t run) {
    NoiseDraw initial(source, run, 0, NoisePurpose::initial), process(source, run, 1, NoisePurpose::process),
        measurement(source, run, 1, NoisePurpose::measurement);
    const auto prior = world.prior();
    filter.reset(prior.mean, prior.covariance);
    const State truth = world.step(world.initial(initial), 1, process);
    NoiseDraw input(source, run, 1, NoisePurpose::process, internal::plugged::kInputSlots);
    internal::plugged::predict(filter, world, internal::plugged::input_of(world, truth, 1, input), 1.0);
    const auto z = world.measure(truth, 1, measurement);
    if constexpr (internal::plugged::IsOptional<std::decay_t<decltype(z)>>::value) {
      if (!z) throw std::invalid_argument("the first step measures nothing: give the world a layout()");
    }
    filter.update(internal::plugged::value_of(z));
    return filter;
  }

  static std::vector<std::pair<std::string, Index>> sensors_of(const Filter& filter) {
    const std::vector<Innovation> innovations = internal::innovations_of(filter);
    std::vector<std::pair<std::string, Index>> sensors;
    for (std::size_t i = 0; i < innovations.size(); ++i) {
      if (innovations[i].nu.size() == 0)
        throw std::invalid_argument("the first step shows no innovation: give the world a layout()");
      std::string name;
      if (innovations.size() > 1) name.append("sensor ").append(std::to_string(i + 1));
      sensors.emplace_back(std::move(name), innovations[i].nu.size());
    }
    return sensors;
  }

  internal::PlugThrown thrown_in(std::int64_t run) const {
    Run play(*this, run);
    play.visit([](const TraceStep&) {});
    return play.thrown();
  }

  /// Two runs in turn, a step of each, are to the last bit what each of them is alone.
  void check_side_by_side(std::vector<std::string>& found) const {
    constexpr std::int64_t kSteps = 20;
    const std::int64_t last = std::min(kSteps, this->steps());
    std::array<std::vector<TraceStep>, 2> alone;
    for (std::size_t run = 0; run < alone.size(); ++run) {
      Run play(*this, static_cast<std::int64_t>(run));
      for (std::int64_t k = 0; k <= last; ++k) {
        alone[run].push_back(play.advance(k));
        if (alone[run].back().outcome != Outcome::ok) return;
      }
    }
    Run first(*this, 0), second(*this, 1);
    for (std::int64_t k = 0; k <= last; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const bool same_first = internal::same_step(first.advance(k), alone[0][i]);
      const bool same_second = internal::same_step(second.advance(k), alone[1][i]);
      if (!same_first || !same_second) return internal::report_shared_state(k, found);
    }
  }

  /// minus(plus(x, d), x) = d for small d, at a truth: the start of a group is its identity, where charts
  /// agree.
  void check_plus(std::vector<std::string>& found) const {
    NoiseDraw initial(source_, 0, 0, NoisePurpose::initial), process(source_, 0, 1, NoisePurpose::process);
    NoiseDraw draw(source_, 0, 0, NoisePurpose::decision);
    const Vector d = 1e-2 * draw.normals(std::ssize(layout().states));
    const State x = world_.step(world_.initial(initial), 1, process);
    internal::report_plus(d, internal::state_minus(world_, State(world_.plus(x, d)), x), found);
  }

  /// From P = 0 a prediction leaves nothing but process noise.
  void check_time_step(std::vector<std::string>& found) const {
    const Prior<State> prior{world_.prior().mean, Matrix::Zero(world_.prior().covariance.rows(),
                                                               world_.prior().covariance.cols())};
    NoiseDraw draw(source_, 0, 1, NoisePurpose::process, internal::plugged::kInputSlots);
    const auto input = internal::plugged::input_of(world_, prior.mean, 1, draw);
    const auto variances = [&](int parts) {
      Filter filter = make_filter_();
      filter.reset(prior.mean, prior.covariance);
      for (int i = 0; i < parts; ++i) internal::plugged::predict(filter, world_, input, 1.0 / parts);
      return Vector(Matrix(filter.covariance()).diagonal());
    };
    try {
      internal::report_time_step(variances(1), variances(2), found);
    } catch (const std::exception&) {
      return;  // a filter that cannot start from certainty
    }
  }

  World world_;
  MakeFilter make_filter_;
  Index delay_;
  NoiseSource source_;
};

}  // namespace credence
