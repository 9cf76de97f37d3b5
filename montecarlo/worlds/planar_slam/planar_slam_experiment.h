#pragma once

#include "montecarlo/engine/shown_experiment.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"

namespace credence::internal {

/// Many runs of one estimator of planar SLAM. NEES is that of the error in the chart of the estimator's P;
/// squared errors are those of x̂ − x.
class PlanarSlamExperiment final : public ShownExperiment {
 public:
  PlanarSlamExperiment(const Scenario& scenario, const NoiseSource& source)
      : PlanarSlamExperiment(scenario, source, make_odometry_world(scenario)) {}

  Outcome visit(std::int64_t run, const StepVisitor& take) const override;
  RunTrace describe_world() const override;

 private:
  class Run;

  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const override;

  PlanarSlamExperiment(const Scenario& scenario, const NoiseSource& source, OdometryWorld world);

  Scenario scenario_;
  OdometryWorld world_;
  NoiseSource source_;
};

}  // namespace credence::internal
