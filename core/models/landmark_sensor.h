#pragma once

#include "core/types.h"

namespace credence::internal {

/// What a planar sensor tells of a landmark at ρ = R(θ)ᵀ (l − p), its place in the vehicle's frame.
enum class LandmarkSensorKind {
  relative_position,  ///< ρ itself, m
  range_bearing,      ///< (|ρ|, atan2 ρ), m and rad
};

/// z = s(ρ), with its Jacobian and inverse. Not finite where the landmark coincides with the vehicle and
/// range and bearing are measured.
struct LandmarkSensor {
  using Vector2 = Eigen::Vector2d;

  LandmarkSensorKind kind = LandmarkSensorKind::relative_position;

  Vector2 measure(const Vector2& rho) const;                 ///< s(ρ)
  Eigen::Matrix2d jacobian(const Vector2& rho) const;        ///< D = ∂s/∂ρ
  Vector2 locate(const Vector2& z) const;                    ///< ρ = s⁻¹(z)
  Eigen::Matrix2d inverse_jacobian(const Vector2& z) const;  ///< ∂s⁻¹/∂z
  /// z − z_predicted, with a bearing wrapped.
  Vector2 innovation(const Vector2& z, const Vector2& predicted) const;
};

}  // namespace credence::internal
