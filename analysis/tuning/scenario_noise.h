#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "analysis/tuning/black_box_score.h"
#include "analysis/tuning/noise_parameters.h"
#include "analysis/tuning/score_model.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// What of a scenario's filter is free, and the runs of its world that tell.

namespace credence::internal {

/// The score of a scenario's runs with the way back from φ to the scenario.
class ScenarioScore {
 public:
  virtual ~ScenarioScore() = default;

  virtual const ScoreModel& model() const = 0;
  virtual Vector start() const = 0;
  /// The scenario whose filter has the noise at φ; of coordinates that equal `start` the keys stay as they
  /// are.
  virtual Scenario scenario_at(const Vector& phi) const = 0;
  /// "linear filter, exact gradient", for reports.
  virtual std::string engine() const = 0;
  /// The name of a parameter of the model as a key of the scenario, and the number by which its values are
  /// multiplied to be those of the key.
  struct Key {
    std::string name;
    double unit = 1.0;
  };
  virtual Key key(const std::string& parameter) const = 0;
  /// For a model that outlives `stop`: its scores do not look at it any more.
  virtual void forget_stop() = 0;
};

/// Plays the study's runs and measures their log score. `threads`: 0 is one for each processor. Once `stop`
/// is set, scores may throw Stopped (stop_point.h).
///
/// A linear world whose filter misses nothing and inflates nothing has the exact gradient; any other filter
/// is a black box of which Q and R have a factor each. Throws
/// std::invalid_argument, naming the key, for noise that the world's filter has not of its own, and where the
/// runs need more memory than kMostDoubles.
std::unique_ptr<ScenarioScore> make_scenario_score(const Scenario& scenario,
                                                   const std::vector<FreeNoise>& free, int threads,
                                                   const std::atomic<bool>* stop = nullptr,
                                                   const PlayCount::Watch& watch = {});

/// Doubles of measurements that are kept at most: 1.6 GB.
inline constexpr double kMostDoubles = 2e8;

}  // namespace credence::internal
