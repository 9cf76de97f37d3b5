#pragma once

#include "montecarlo/worlds/estimator_contest.h"
#include "montecarlo/worlds/planar_slam/odometry_world.h"

namespace credence {

/// The posterior Cramér-Rao bound of pose and map by the recursion of [Tichavsky 1998],
///
///   J⁺ = D₂₂ − D₂₁ (J + D₁₁)⁻¹ D₁₂,   D₁₁ = E[Fᵀ Q⁻¹ F], D₁₂ = −E[Fᵀ Q⁻¹], D₂₂ = Q⁻¹ + E[Hᵀ R⁻¹ H],
///
/// in the form of covariances, which stands a singular Q and start: the vehicle never leaves its path, so
/// that all expectations are the Jacobians on it, but for the sights that are missed, E[Hᵀ R⁻¹ H] =
/// p Hᵀ R⁻¹ H. Of the map nothing is known before. Noise is the world's, whatever a filter believes.
/// O(n²) a step.
PosteriorBound posterior_bound(const OdometryWorld& world);

}  // namespace credence
