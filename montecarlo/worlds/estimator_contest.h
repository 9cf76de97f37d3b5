#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

/// @file
/// What a world offers for a comparison of several estimators: run by run the same noise for all, and of each
/// step what is judged.

namespace credence::internal {

/// What is judged.
enum class EstimatorBlock : std::size_t {
  pose,            ///< in the estimator's chart; of a world without a vehicle the whole state
  heading,         ///< or attitude: the same in every chart
  position,        ///< x̂ − x with P transported
  map,             ///< in the estimator's chart, at some steps
  plane_pose,      ///< pose as x̂ − x with P transported
  chart_position,  ///< position, in the estimator's chart
  count_,
};
inline constexpr std::size_t kEstimatorBlocks = static_cast<std::size_t>(EstimatorBlock::count_);

/// What is judged of one estimator at one step.
struct EstimatorStep {
  EstimatorStep() { nees.fill({0.0, 0}); }
  NeesValue& operator[](EstimatorBlock block) { return nees[static_cast<std::size_t>(block)]; }

  std::array<NeesValue, kEstimatorBlocks> nees;          ///< dof 0: not judged here; −1: P is no covariance
  double heading_squared = 0.0, heading_variance = 0.0;  ///< rad²: of the error, and what P says of it
  double position_squared = 0.0, position_variance = 0.0;  ///< m²
  bool converged = true;                                   ///< UpdateResult::converged
};

/// The posterior Cramér-Rao bound on the mean squared errors of the vehicle, each averaged over the steps.
struct VehicleBound {
  double heading_squared = 0.0;   ///< rad²
  double position_squared = 0.0;  ///< m²
};

/// What is known of an estimator without any run of the comparison.
struct EstimatorProfile {
  std::string_view chart = "plane";  ///< the word for the chart of its P; "plane" is x̂ − x
  std::string_view chart_text = "x̂ − x";
  /// Unknowns among which the rows of the observability matrix tell; see EstimatorContest::profile.
  Index known = 0;
  /// Of predict and update alone, of a run that was simulated before; what else it holds in a world the note
  /// of the world says.
  double seconds_per_step = 0.0;
};

/// Hears what the estimators show.
class EstimatorListener {
 public:
  virtual ~EstimatorListener() = default;
  /// Step k ≥ 1 of estimator e, in their order; false: it is to be stopped in this run.
  virtual bool take(std::size_t e, Index k, const EstimatorStep& step) = 0;
  /// Estimator e failed at step k, and is not heard of again in this run.
  virtual void failed(std::size_t e, Index k, Outcome outcome) = 0;
};

/// One thread's estimators.
class EstimatorPlayer {
 public:
  virtual ~EstimatorPlayer() = default;
  /// All of them through one run, with the same noise.
  virtual void play(std::int64_t run, EstimatorListener& listener) = 0;
};

/// A world made ready for a comparison. All const and safe to call from several threads.
class EstimatorContest {
 public:
  using TakeRow = std::function<void(const VectorRef& row)>;

  virtual ~EstimatorContest() = default;
  virtual Index steps() const = 0;
  virtual Index map_stride() const { return 10; }  ///< the map is judged at every so many steps
  virtual std::unique_ptr<EstimatorPlayer> player(std::span<const std::string> names) const = 0;
  /// Run 0 with one estimator. `take_row` gets rows of the observability matrix at its own Jacobians, of
  /// unknowns() columns; rank deficient by the same number as the whole.
  virtual EstimatorProfile profile(std::string_view name, const TakeRow& take_row) const = 0;
  virtual Index unknowns() const = 0;
  /// For measurements that arrive in time and noise that is white and Gaussian; NaN: not known.
  virtual VehicleBound bound() const = 0;
  /// false: the states are no vehicle's, but any; position is then all of them, each in its unit.
  virtual bool has_vehicle() const { return true; }
  /// What a reader of the table must know of this world.
  virtual std::string note() const = 0;
};

/// How a world is compared: its estimators, and how a comparison of them is made.
struct EstimatorOffer {
  /// Those that a scenario says enough for; of null all there are.
  std::vector<std::string_view> (*names)(const Scenario*);
  std::unique_ptr<EstimatorContest> (*contest)(const Scenario&);
};

}  // namespace credence::internal
