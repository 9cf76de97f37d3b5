#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/filters/slam_phases.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/landmark_draws.h"
#include "montecarlo/worlds/planar/planar_world.h"

namespace credence {

/// Standard deviations of the true noise of a planar world.
struct PlanarNoise {
  Control control_std;                 ///< in the units of the vehicle's control
  RangeBearing measurement_std;        ///< m, rad
  Pose initial_std;                    ///< m, m, rad
  double detection_probability = 1.0;  ///< of a landmark in view
  Index measurement_delay = 0;         ///< steps after which a filter has what is seen

  static PlanarNoise of(const Scenario& scenario);

  /// Of the start: diag(initial_std²).
  Eigen::Matrix3d initial_covariance() const { return initial_std.cwiseAbs2().asDiagonal(); }
};

}  // namespace credence

namespace credence::internal {

/// What happens in one run of a planar world, whatever filter watches it: where the vehicle really drives and
/// what its sensor says. A run is started, then each step is moved and observed, in order.
///
/// The vehicle drives its nominal controls plus noise, from the nominal start. Nothing is allocated after the
/// construction, but for noise that is late or not plain. `world` must live as long.
class PlanarSimulation {
 public:
  /// Without a source of noise the nominal path is driven and the sensor exact.
  PlanarSimulation(const PlanarWorld& world, const PlanarNoise& noise, std::optional<NoiseSource> source);

  /// Starts a run; returns where a filter believes it to start: the truth plus an error of the initial
  /// covariance.
  Pose start(std::int64_t run);

  /// The vehicle moves by step k, from 1 on.
  void move(std::size_t k);

  /// What the filter is given at step k: what was seen from where the vehicle is, or was a delay ago; good
  /// until the next call.
  std::span<const Observation<PlanarModel>> observe(std::size_t k);

  const Pose& pose() const { return pose_; }  ///< the true one

 private:
  const PlanarWorld& world_;
  PlanarNoise noise_;
  std::optional<NoiseSource> source_;
  Pose pose_;
  LandmarkDraws<Observation<PlanarModel>> draws_;
  /// Landmarks within range, and where they lie from the vehicle.
  struct InRange {
    std::vector<std::size_t> landmark;
    std::vector<double> dx, dy, direction;
  };
  void find_in_range(const double* detected);

  InRange in_range_;
};

/// What the steps of runs in a planar world have in common.
RunLayout planar_layout(const PlanarWorld& world);

/// Fills in truth, error x̂ ⊟ x (the heading wrapped) and states of a step with an estimate and its landmarks.
void record_planar_error(const Pose& pose, const PlanarWorld& world, TraceStep& step);

/// What a trace says of a planar world.
RunTrace describe_planar_world(const PlanarWorld& world);

}  // namespace credence::internal
