#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "montecarlo/worlds/plugged/batch_experiment.h"
#include "montecarlo/worlds/plugged/model_plug.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"
#include "reports/document/judge/judged_filter.h"

/// @file
/// The whole way from a user's own filter to a verdict, in one call (docs/plugin.md).

namespace credence {

/// How a filter is played and judged.
struct JudgeOptions {
  std::string name = "filter";  ///< for titles and files
  std::int64_t runs = 1000, steps = 100;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one for each processor; the bits do not depend on it
  double confidence =
      0.95;               ///< a consistent filter is called anything else with probability 1 − this at most
  double dt = 0.0;        ///< length of a step [s], for times in reports; 0: world.dt() if there is one
  bool inflated = false;  ///< the filter inflates its covariance on purpose
  bool check_plug = true;  ///< play a few runs first, and throw where something is wrong with them
  /// What makes the noise of the world other than a filter believes.
  NoiseShape process_noise{}, measurement_noise{};
  Index measurement_delay = 0;  ///< steps after which a measurement reaches the filter
  /// Set, by another thread or a signal: what was played until then is judged.
  const std::atomic<bool>* stop = nullptr;
  JudgeProgress progress{};  ///< of the runs

  PlugSettings plug() const {
    return {.steps = steps,
            .seed = seed,
            .process_shape = process_noise,
            .measurement_shape = measurement_noise,
            .measurement_delay = measurement_delay};
  }
};

}  // namespace credence

namespace credence::internal {

/// Throws std::invalid_argument for an option that is out of its range.
void require_accepted(const JudgeOptions& options);

/// The options, with the time of a step of the world where it has one and they do not.
template <class World>
JudgeOptions accepted(JudgeOptions options, const World& world) {
  require_accepted(options);
  if constexpr (HasTimeStep<World>) {
    if (options.dt == 0.0) options.dt = world.dt();
  }
  return options;
}

}  // namespace credence::internal

namespace credence {

/// Judges an experiment by all of its runs. `said(run)` is asked what a filter that threw said. Throws
/// std::invalid_argument for an option that is out of its range and std::runtime_error where it was stopped
/// before the first runs were done.
JudgedFilter judge_experiment(const Experiment& experiment, const JudgeOptions& options,
                              const std::function<std::string(std::int64_t)>& said = {});

/// Judges a filter in a world: PluggedWorld and PluggedFilter say what they must be.
///
/// A run whose filter throws, or whose numbers are not finite, failed: it is counted, and named with its
/// number, step, and what was said. Throws std::invalid_argument, before the study, naming what is wrong with
/// the plug itself (plug_problems).
template <class World, class MakeFilter>
JudgedFilter judge_filter(World world, MakeFilter make_filter, const JudgeOptions& options = {}) {
  using Filter = std::invoke_result_t<const MakeFilter&>;
  internal::require_plug<World, Filter>();
  if constexpr (PluggedWorld<World> && PluggedFilter<Filter, World>) {
    const JudgeOptions with_time = internal::accepted(options, world);
    const PluggedExperiment<World, MakeFilter> experiment(std::move(world), std::move(make_filter),
                                                          options.plug());
    if (options.check_plug) internal::require_sound(experiment.problems());
    return judge_experiment(experiment, with_time, [&](std::int64_t run) { return experiment.said(run); });
  } else {
    throw std::invalid_argument("no world and filter that fit");  // refused by the compiler above
  }
}

/// The same for a filter that brings lanes (BatchFilter): `make_batch()` gives one of kLanes runs.
template <class World, class MakeBatch>
JudgedFilter judge_batch(World world, MakeBatch make_batch, const JudgeOptions& options = {}) {
  const JudgeOptions with_time = internal::accepted(options, world);
  const BatchExperiment<World, MakeBatch> experiment(std::move(world), std::move(make_batch), options.plug());
  if (options.check_plug) internal::require_sound(experiment.problems());
  return judge_experiment(experiment, with_time, [&](std::int64_t run) { return experiment.said(run); });
}

/// Judges the extended Kalman filter of a model in the world of that model, or of another one, beside the
/// posterior Cramér-Rao bound of its errors. Throws std::invalid_argument where the two differ in their
/// dimensions.
JudgedFilter judge_model(const FunctionModel& truth, const FunctionModel& believed,
                         const JudgeOptions& options = {});

}  // namespace credence
