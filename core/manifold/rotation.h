#pragma once

#include "core/manifold/trigonometric_series.h"
#include "core/manifold/trigonometry.h"
#include "core/types.h"

/// @file
/// Rotations in the plane and the group SE_{1+N}(2) of a pose and N landmarks, on which the invariant filters
/// live ([Barrau 2015]).

namespace credence::internal {

/// R(φ).
inline Eigen::Matrix2d rotation(double angle_rad) {
  const auto [s, c] = sine_cosine(angle_rad);
  Eigen::Matrix2d R;
  R << c, -s, s, c;
  return R;
}

/// J v, J = dR/dφ at 0: v turned by a right angle to the left.
inline Eigen::Vector2d quarter_turn(const Eigen::Vector2d& v) { return {-v[1], v[0]}; }

/// V(φ) = ∫₀¹ R(tφ) dt: exp of (φ, ξ) in SE(2) has the translation V(φ) ξ, of SE_{1+N}(2) each of its 1 + N.
inline Eigen::Matrix2d exponential_factor(double angle_rad) {
  const TrigonometricSeries s = trigonometric_series(angle_rad);
  const double a = s.s1, b = angle_rad * s.s2;
  Eigen::Matrix2d V;
  V << a, -b, b, a;
  return V;
}

/// V(φ)⁻¹, for |φ| ≤ π.
inline Eigen::Matrix2d logarithm_factor(double angle_rad) {
  const Eigen::Matrix2d V = exponential_factor(angle_rad);
  return V.transpose() / (V(0, 0) * V(0, 0) + V(1, 0) * V(1, 0));  // a multiple of a rotation
}

/// W(φ) = ∫₀¹ V(sφ) s ds: the left Jacobian of exp in SE_{1+N}(2), exp(ξ + ε) = exp(𝒥 ε) exp(ξ) to first
/// order, takes (ε_φ, ε_i) to (ε_φ, V(φ) ε_i − J W(φ) ξ_i ε_φ).
inline Eigen::Matrix2d exponential_curvature(double angle_rad) {
  const TrigonometricSeries s = trigonometric_series(angle_rad);
  const double a = s.s2, b = angle_rad * s.s3;
  Eigen::Matrix2d W;
  W << a, -b, b, a;
  return W;
}

}  // namespace credence::internal
