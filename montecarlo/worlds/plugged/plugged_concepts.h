#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "core/types.h"
#include "montecarlo/worlds/plugged/noise_draw.h"

/// @file
/// What a world and a filter of a user's own must be to be judged (docs/plugin.md).

namespace credence {

/// What is believed of the state before the first step.
template <class State>
struct Prior {
  State mean;
  Matrix covariance;  ///< n×n, of minus(estimate, truth)
};

}  // namespace credence

namespace credence::internal {

/// The state of a world: any type.
template <class World>
using StateOf = std::decay_t<decltype(std::declval<const World&>().prior().mean)>;

/// a ⊟ b, n: by a member of the world, a function beside the type of the state, or as vectors.
template <class World, class State>
Vector state_minus(const World& world, const State& a, const State& b) {
  if constexpr (requires { Vector(world.minus(a, b)); }) {
    return world.minus(a, b);
  } else if constexpr (requires { Vector(minus(a, b)); }) {
    return minus(a, b);
  } else {
    return a - b;
  }
}

/// Whether the filter is given an input at each prediction.
template <class World>
concept HasInput = requires(const World& world, const StateOf<World>& x, std::int64_t k, NoiseDraw& noise) {
  world.input(x, k, noise);
};

/// Whether the filter is told how long a prediction is, in s.
template <class World>
concept HasTimeStep = requires(const World& world) {
  { world.dt() } -> std::convertible_to<double>;
};

namespace plugged {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class T>
const T& value_of(const T& measurement) {
  return measurement;
}
template <class T>
const T& value_of(const std::optional<T>& measurement) {
  return *measurement;
}

/// What the world gives a prediction; nothing where it has no input.
struct NoInput {};
template <class World>
auto input_of(const World& world, const StateOf<World>& x, std::int64_t k, NoiseDraw& noise) {
  if constexpr (HasInput<World>) {
    return world.input(x, k, noise);
  } else {
    return NoInput{};
  }
}
template <class World>
using InputOf = decltype(input_of(std::declval<const World&>(), std::declval<const StateOf<World>&>(),
                                  std::int64_t{}, std::declval<NoiseDraw&>()));

template <class Filter, class Input, class... Time>
concept Predicts = (std::is_same_v<Input, NoInput>
                        ? requires(Filter & filter, Time... time) { filter.predict(time...); }
                        : requires(Filter & filter, const Input& input, Time... time) {
                            filter.predict(input, time...);
                          });

/// Predicts `share` of a step.
template <class Filter, class World, class Input>
requires(HasTimeStep<World> ? Predicts<Filter, Input, double>
                            : Predicts<Filter, Input>) void predict(Filter& filter, const World& world,
                                                                    const Input& input, double share) {
  if constexpr (HasTimeStep<World> && HasInput<World>) {
    filter.predict(input, share * world.dt());
  } else if constexpr (HasTimeStep<World>) {
    filter.predict(share * world.dt());
  } else if constexpr (HasInput<World>) {
    filter.predict(input);
  } else {
    filter.predict();
  }
}

}  // namespace plugged

}  // namespace credence::internal

namespace credence {

/// A world draws a truth, moves it, and measures it; it has no random generator of its own.
///
/// prior() is what the filter starts from; initial(noise) the truth at the start; step(x, k, noise) the truth
/// at step k = 1, 2, … from that of the step before; measure(x, k, noise) what the filter is given, or a
/// std::optional of it, empty where nothing is measured. All const, and safe to call from several threads.
///
/// It may have: minus(a, b); plus(x, d), which is compared with it; input(x, k, noise), what the filter's
/// predict is given; dt(), the time of a step, which it is given behind the input; layout(), with the names,
/// angles, units, blocks and sensors (model_layout makes one); coordinates(x), n numbers that say
/// where x is, for figures and logs of a state that is no vector: the estimate is shown at those of the truth
/// plus its error.
template <class World>
concept PluggedWorld = requires(const World& world, const internal::StateOf<World>& x, std::int64_t k,
                                NoiseDraw& noise) {
  { world.prior().covariance } -> std::convertible_to<Matrix>;
  { world.initial(noise) } -> std::convertible_to<internal::StateOf<World>>;
  { world.step(x, k, noise) } -> std::convertible_to<internal::StateOf<World>>;
  world.measure(x, k, noise);
  { internal::state_minus(world, x, x) } -> std::convertible_to<Vector>;
};

/// A filter starts from a mean and its covariance, predicts, updates, and shows its state and covariance.
///
/// update may return a bool: false where S is not positive definite, which ends the run. An exception
/// ends the run too; both are counted and named. It may have innovations(), one Innovation for each
/// sensor (empty where it is silent), or innovation() and innovation_covariance(), for NIS. One whose number
/// of states changes, as landmarks appear, has states(): the numbers, in the world's layout, of those that it
/// has; its error and covariance() are of these, in this order.
template <class Filter, class World>
concept PluggedFilter = requires(Filter& filter, const Filter& shown, const World& world,
                                 const internal::StateOf<World>& x, std::int64_t k, NoiseDraw& noise) {
  filter.reset(world.prior().mean, world.prior().covariance);
  filter.update(internal::plugged::value_of(world.measure(x, k, noise)));
  {
    internal::state_minus(world, static_cast<const internal::StateOf<World>&>(shown.state()), x)
    } -> std::convertible_to<Vector>;
  { shown.covariance() } -> std::convertible_to<Matrix>;
}
&&requires(Filter& filter, const World& world, const internal::StateOf<World>& x, std::int64_t k,
           NoiseDraw& noise) {
  internal::plugged::predict(filter, world, internal::plugged::input_of(world, x, k, noise), 1.0);
};

}  // namespace credence

namespace credence::internal {

/// What may be there is not seen where it is not const: then it would silently not be used.
template <class World, class Filter>
constexpr void require_const() {
  using State = StateOf<World>;
  constexpr bool kMinus = !requires(World & world, const State& x) { world.minus(x, x); }
  || requires(const World& world, const State& x) { world.minus(x, x); };
  static_assert(kMinus, "minus(a, b) of the world must be const: else it is not used");
  constexpr bool kPlus = !requires(World & world, const State& x, const Vector& d) { world.plus(x, d); }
  || requires(const World& world, const State& x, const Vector& d) { world.plus(x, d); };
  static_assert(kPlus, "plus(x, d) of the world must be const: else it is not used");
  constexpr bool kInput = !requires(World & world, const State& x, std::int64_t k, NoiseDraw& noise) {
    world.input(x, k, noise);
  }
  || HasInput<World>;
  static_assert(kInput, "input(x, k, noise) of the world must be const: else it is not used");
  constexpr bool kTimeStep = !requires(World & world) { world.dt(); }
  || HasTimeStep<World>;
  static_assert(kTimeStep, "dt() of the world must be const and give a number: else it is not used");
  constexpr bool kLayout = !requires(World & world) { world.layout(); }
  || requires(const World& world) { RunLayout(world.layout()); };
  static_assert(kLayout, "layout() of the world must be const and give a RunLayout: else it is not used");
  constexpr bool kInnovations = !requires(Filter & filter) { filter.innovations(); }
  || requires(const Filter& filter) { filter.innovations(); };
  static_assert(kInnovations, "innovations() of the filter must be const: else it is not used");
  constexpr bool kInnovation = !requires(Filter & filter) { filter.innovation(); }
  || requires(const Filter& filter) {
    filter.innovation();
    filter.innovation_covariance();
  };
  static_assert(kInnovation,
                "innovation() of the filter needs innovation_covariance() beside it, and both must be const");
  constexpr bool kStates = !requires(Filter & filter) { filter.states(); }
  || requires(const Filter& filter) { filter.states(); };
  static_assert(kStates, "states() of the filter must be const: else it is not used");
}

/// Says in a sentence what a world or a filter lacks, where a concept says only that it is not satisfied.
template <class World, class Filter>
constexpr void require_plug() {
  constexpr bool kPrior = requires(const World& world) {
    { world.prior().covariance } -> std::convertible_to<Matrix>;
    world.prior().mean;
  };
  static_assert(kPrior, "the world needs prior() const, which gives {mean, covariance}");
  if constexpr (kPrior) {
    require_const<World, Filter>();
    using State = StateOf<World>;
    constexpr bool kInitial = requires(const World& world, NoiseDraw& noise) {
      { world.initial(noise) } -> std::convertible_to<State>;
    };
    static_assert(kInitial,
                  "the world needs initial(noise) const, which gives the truth at the start, of the type of "
                  "prior().mean");
    constexpr bool kStep = requires(const World& world, const State& x, std::int64_t k, NoiseDraw& noise) {
      { world.step(x, k, noise) } -> std::convertible_to<State>;
    };
    static_assert(kStep, "the world needs step(x, k, noise) const, which gives the truth at step k");
    constexpr bool kMeasure = requires(const World& world, const State& x, std::int64_t k, NoiseDraw& noise) {
      world.measure(x, k, noise);
    };
    static_assert(kMeasure,
                  "the world needs measure(x, k, noise) const, which gives what the filter is given");
    constexpr bool kMinus = requires(const World& world, const State& x) {
      { state_minus(world, x, x) } -> std::convertible_to<Vector>;
    };
    static_assert(kMinus,
                  "the world needs minus(estimate, truth) const, which gives the error as a Vector, unless "
                  "states are vectors");
    constexpr bool kReset = requires(Filter & filter, const World& world) {
      filter.reset(world.prior().mean, world.prior().covariance);
    };
    static_assert(kReset, "the filter needs reset(mean, P), which takes what the world's prior() gives");
    constexpr bool kState = requires(const Filter& filter) { static_cast<const State&>(filter.state()); };
    static_assert(kState, "the filter needs state() const, of the type of the world's prior().mean");
    constexpr bool kCovariance = requires(const Filter& filter) {
      { filter.covariance() } -> std::convertible_to<Matrix>;
    };
    static_assert(kCovariance, "the filter needs covariance() const, which gives a Matrix");
    if constexpr (kMeasure) {
      constexpr bool kUpdate =
          requires(Filter & filter, const World& world, const State& x, std::int64_t k, NoiseDraw& noise) {
        filter.update(plugged::value_of(world.measure(x, k, noise)));
      };
      static_assert(kUpdate, "the filter needs update(z), which takes what the world's measure() gives");
    }
    constexpr bool kPredict =
        requires(Filter & filter, const World& world, const State& x, std::int64_t k, NoiseDraw& noise) {
      plugged::predict(filter, world, plugged::input_of(world, x, k, noise), 1.0);
    };
    static_assert(kPredict,
                  "the filter needs predict(): with the world's input() if it has one, and behind that the "
                  "time of a step if the world has dt()");
  }
}

/// Whether the filter says which states of the layout it has, as its number of states changes.
template <class Filter>
concept HasStates = requires(const Filter& filter) {
  { *filter.states().begin() } -> std::convertible_to<Index>;
};

/// Whether it shows innovations at all.
template <class Filter>
inline constexpr bool kShowsInnovations = requires(const Filter& filter) {
  filter.innovations();
}
|| requires(const Filter& filter) { filter.innovation(); };

/// The innovations that a filter shows after an update; none if it shows none.
template <class Filter>
std::vector<Innovation> innovations_of(const Filter& filter) {
  if constexpr (requires { filter.innovations(); }) {
    constexpr bool kGivesThem = requires {
      { *filter.innovations().begin() } -> std::convertible_to<const Innovation&>;
    };
    static_assert(kGivesThem,
                  "innovations() of a filter gives a std::vector<Innovation>, one for each sensor");
    if constexpr (kGivesThem) {
      const auto& shown = filter.innovations();
      return {shown.begin(), shown.end()};
    } else {
      return {};
    }
  } else if constexpr (requires { filter.innovation(); }) {
    return {{filter.innovation(), filter.innovation_covariance()}};
  } else {
    return {};
  }
}

/// The layout of a state with these names ("heading:angle" is an angle in rad, "v [m/s]" in this unit,
/// "pose.x" of a block "pose") and of sensors with these names and dimensions.
RunLayout model_layout(const std::vector<std::string>& states,
                       const std::vector<std::pair<std::string, Index>>& sensors);

}  // namespace credence::internal
