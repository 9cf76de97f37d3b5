#pragma once

#include <vector>

#include "core/filters/spatial/spatial_slam.h"
#include "core/record/run_layout.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/landmark_draws.h"

namespace credence::internal {

/// A vehicle that flies a closed path in space exactly, its odometry and its sensor of landmarks noisy: the
/// world of [Zhang 2017]. The path is an ellipse seen from above that rises and falls twice a loop, the
/// vehicle looks along it; landmarks are drawn about the path, a function of world.map alone.
struct SpatialWorld {
  /// A landmark as it is seen without noise.
  struct Exact {
    int landmark;
    Eigen::Vector3d z;
  };

  std::vector<SE3> path;                 ///< true poses of steps 0 … T
  std::vector<SpatialControl> controls;  ///< true, of steps 1 … T
  std::vector<Eigen::Vector3d> landmarks;
  std::vector<std::vector<Exact>> in_view;  ///< at steps 0 … T
  double landmark_noise = 0.0;              ///< standard deviation over what is measured
  bool by_length = true;                    ///< the length of a measured vector, else each coordinate
  Eigen::Matrix<double, 6, 1> initial_std;  ///< (δp, φ)
  double process_scale = 1.0, measurement_scale = 1.0;  ///< what the filter believes of the variances
  double detection_probability = 1.0;
  Index measurement_delay = 0;  ///< steps after which a filter has what is seen
  double width_m = 0.0;         ///< an error above this is divergence

  Index steps() const { return std::ssize(controls); }
  SpatialTruth truth(std::size_t k) const { return {path[k > 0 ? k - 1 : 0], path[k], landmarks}; }
  /// Of the noise, over its square, on a vector measured: |v|² thrice, or the square of each coordinate.
  Eigen::Vector3d squares(const Eigen::Vector3d& v) const;
  Eigen::Vector3d landmark_variances(const Eigen::Vector3d& z) const {
    return landmark_noise * landmark_noise * squares(z);
  }
  SpatialSlam::PoseMatrix initial_covariance() const { return initial_std.cwiseAbs2().asDiagonal(); }
};

SpatialWorld make_spatial_world(const Scenario& scenario);

/// Of the pose alone, its errors stated by differences.
RunLayout spatial_layout(const SpatialWorld& world);

/// What odometry and sensor say in one run, whatever filter listens, with the variances that it believes.
///
/// Noise of run i: step 0, purpose initial, slots 0 … 5; then LandmarkDraws, that of the motion on v and ω
/// read.
class SpatialSimulation {
 public:
  /// `world` must live as long.
  SpatialSimulation(const SpatialWorld& world, const NoiseSource& source);

  /// Where a filter believes the run to start.
  SE3 start(std::int64_t run);
  SpatialControl read(std::size_t k);  ///< of step k, from 1 on
  /// What was seen at step k, or a delay before; good until the next call.
  std::span<const SpatialObservation> observe(std::size_t k);

 private:
  const SpatialWorld& world_;
  NoiseSource source_;
  LandmarkDraws<SpatialObservation> draws_;
};

}  // namespace credence::internal
