#pragma once

#include <optional>
#include <vector>

#include "core/manifold/se2.h"
#include "montecarlo/worlds/charted/charted_settings.h"

namespace credence::internal {

/// A vehicle that drives a circle exactly and reads its odometry, aided by satellites or known landmarks
/// ([Barrau 2017], section IV): x = (R, p), x⁺ = x (Exp(ω dt), v dt).
///
/// The odometry reads v (along and across) and ω with noise. A fix is p + w; a landmark's Rᵀ(l − p) + w.
class LocalisationModel {
 public:
  using Group = SE2;
  static constexpr const char* kCoordinates = "SE(2): place p (m), heading (rad)";
  using Input = Eigen::Vector3d;  ///< v (m/s), ω (rad/s)

  /// Of a scenario of the localisation world.
  explicit LocalisationModel(const Scenario& scenario);

  Group start() const { return {}; }
  const Group::Tangent& initial_std() const { return initial_std_; }
  Group step(const Group& x, std::int64_t k, NoiseDraw& noise) const;
  Input input(const Group& x, std::int64_t k, NoiseDraw& noise) const;
  std::optional<Aiding> measure(const Group& x, std::int64_t k, NoiseDraw& noise) const;

  ChartedMotion<Group> motion(const Group& x, const Input& u) const;
  ChartedInnovation<Group> innovation(const Group& x, const Aiding& seen) const;
  const RunLayout& layout() const { return layout_; }
  const std::vector<Eigen::Vector2d>& landmarks() const { return landmarks_; }  ///< that are known

 private:
  SE2 increment(const Input& u) const { return {SO2(u[2] * dt_s_), dt_s_ * u.head<2>()}; }

  double dt_s_;
  Input control_, control_std_;
  Group::Tangent initial_std_;
  AidingSettings aiding_;
  std::vector<Eigen::Vector2d> landmarks_;
  double process_scale_, measurement_scale_;
  RunLayout layout_;
};

}  // namespace credence::internal
