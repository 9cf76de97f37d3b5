#pragma once

#include <concepts>
#include <span>
#include <type_traits>

#include "core/filters/ekf_slam.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence {

/// A planar SLAM filter that the Monte Carlo engine can judge; EkfSlam<PlanarModel> is one.
///
/// reset(pose, P) starts a run with an empty map; predict(u) moves by one step of the scenario's dt with the
/// control u; update(z) takes what is seen there. state() is [pose; landmarks in the order of landmarks()],
/// covariance() its P, dense or any other PlanarCovariance. A factorisation that fails is UpdateResult::ok =
/// false, never an exception.
template <class F>
concept PlanarSlamFilter = requires(F filter, const F& constant, const Pose& pose, const Eigen::Matrix3d& P,
                                    const Control& u, std::span<const Observation<PlanarModel>> z) {
  filter.reset(pose, P);
  filter.predict(u);
  { filter.update(z) } -> std::convertible_to<UpdateResult>;
  { constant.state() } -> std::convertible_to<const Vector&>;
  requires PlanarCovariance<std::remove_cvref_t<decltype(constant.covariance())>>;
  { constant.landmarks() } -> std::convertible_to<std::span<const int>>;
  { constant.innovation() } -> std::convertible_to<VectorRef>;
  { constant.innovation_covariance() } -> std::convertible_to<MatrixRef>;
  { constant.gain() } -> std::convertible_to<MatrixRef>;
};

}  // namespace credence
