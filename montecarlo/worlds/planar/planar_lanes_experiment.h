#pragma once

#include "montecarlo/engine/shown_experiment.h"
#include "montecarlo/lanes/planar_lanes.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {

/// Many runs of EKF-SLAM in one planar world, eight at a time (see PlanarLanes): the same
/// worlds and noise as those of PlanarExperiment.
class PlanarLanesExperiment final : public ShownExperiment {
 public:
  /// The largest map for which it pays whatever is in view. With few landmarks in view a matrix filter is as
  /// fast here and faster beyond, where a batch of runs no longer fits the cache.
  static constexpr Index kMaxLandmarks = 40;

  /// `noise` is the true one, Q and the variances of range and bearing are what the filter assumes;
  /// `inflate_map` as for PlanarLanes.
  PlanarLanesExperiment(PlanarWorld world, const PlanarNoise& noise, NoiseSource source,
                        const Eigen::Matrix2d& Q, const RangeBearing& measurement_variance,
                        bool inflate_map = false)
      : ShownExperiment(planar_layout(world)),
        world_(std::move(world)),
        noise_(noise),
        source_(source),
        Q_(Q),
        variance_(measurement_variance),
        inflate_map_(inflate_map) {}

  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  std::int64_t runs_side_by_side() const override { return PlanarLanes::kLanes; }
  std::vector<Outcome> visit_runs(std::int64_t first_run, std::int64_t runs,
                                  const RunsVisitor& take) const override;
  RunTrace describe_world() const override { return describe_planar_world(world_); }

 private:
  class Batch;

  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const override;

  PlanarWorld world_;
  PlanarNoise noise_;
  NoiseSource source_;
  Eigen::Matrix2d Q_;
  RangeBearing variance_;
  bool inflate_map_;
};

}  // namespace credence::internal
