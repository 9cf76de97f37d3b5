#pragma once

#include "core/models/linear_model.h"
#include "core/models/range_bearing.h"
#include "montecarlo/engine/shown_experiment.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {

/// Many runs of an extended Kalman filter that tracks a target by range and bearing from the origin; a step
/// may be missed.
///
/// Noise of run i: step 0, purpose initial, slots 0 … 3; step k, purpose process, slots 0 … 3; purpose
/// measurement, slots 0 and 1; purpose detection, slot 0.
class RangeBearingTracking final : public ShownExperiment {
 public:
  /// Of a scenario of the tracking world with world.sensor = "range_bearing".
  RangeBearingTracking(const Scenario& scenario, NoiseSource source);

  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  RunTrace describe_world() const override { return {}; }

 private:
  class Run;

  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const override;

  LinearModel motion_;  ///< of the target; its measurement is not used
  Vector start_;
  RangeBearing measurement_std_;
  double detection_probability_, process_scale_, measurement_scale_;
  Index delay_, steps_;
  NoiseSource source_;
};

/// The posterior Cramér-Rao bound of position and velocity.
PosteriorBound range_bearing_bound(const Scenario& scenario);

}  // namespace credence::internal
