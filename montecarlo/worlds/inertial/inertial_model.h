#pragma once

#include <optional>
#include <vector>

#include "core/manifold/product_group.h"
#include "core/manifold/sek3.h"
#include "core/manifold/vector_group.h"
#include "montecarlo/worlds/charted/charted_settings.h"

namespace credence::internal {

/// A vehicle that flies a level circle with a strapdown inertial unit, aided by satellites or known landmarks
/// ([Barrau 2017], section V), on a flat Earth that stands still.
///
/// x = (p, v, R; b_g, b_a) in SE_2(3) × R⁶. In a step the biases walk, and then, with ω the rate and f the
/// specific force less their biases and a = R f + g:
/// R⁺ = R Exp(ω dt), v⁺ = v + a dt, p⁺ = p + v dt + a dt²/2.
/// The truth obeys the same equations, so that nothing but noise parts them, unless the unit cones: its axis
/// then moves on a cone of half-angle θ at the rate Ω, and as a reading is the mean of a step the filter
/// drifts by Ω θ²/2 (1 − sin(Ω dt)/(Ω dt)) about the cone's axis ([Bortz 1971]), which it does not know of.
/// If the coning unit is also shaken, by B cos(Ωt) upwards where its tilt is θ (cos Ωt, sin Ωt, 0), what it
/// reads of that in its moving axes is taken in those of the start of a step, and the filter's velocity
/// drifts in the path's axes by θB/2 (1 − sin(Ω dt)/(Ω dt)) along y, sculling ([Savage 1998]), and by −θB/2
/// (1 − cos(Ω dt))/(Ω dt) along x, which is the turn within the step. Satellites give p and v with noise, a
/// landmark Rᵀ(l − p) with noise.
class InertialModel {
 public:
  using Group = ProductGroup<SE23, VectorGroup<6>>;
  static constexpr const char* kCoordinates =
      "SE_2(3) x R^6: place p (m), velocity v (m/s), attitude R = Exp of a rotation vector (rad), biases of "
      "gyro (rad/s) and accelerometer (m/s^2)";
  using Input = Eigen::Matrix<double, 6, 1>;  ///< rate (rad/s) and specific force (m/s²), as read

  /// Of a scenario of the inertial world.
  explicit InertialModel(const Scenario& scenario);

  Group start() const;
  const Group::Tangent& initial_std() const { return initial_std_; }
  Group step(const Group& x, std::int64_t k, NoiseDraw& noise) const;
  Input input(const Group& x, std::int64_t k, NoiseDraw& noise) const;
  std::optional<Aiding> measure(const Group& x, std::int64_t k, NoiseDraw& noise) const;

  ChartedMotion<Group> motion(const Group& x, const Input& u) const;
  ChartedInnovation<Group> innovation(const Group& x, const Aiding& seen) const;
  const RunLayout& layout() const { return layout_; }
  const std::vector<Eigen::Vector3d>& landmarks() const { return landmarks_; }  ///< that are known

 private:
  /// Without biases and noise.
  SE23 moved(const SE23& x, const Eigen::Vector3d& rate, const Eigen::Vector3d& force) const;
  Eigen::Vector3d true_rate(const SE23& x) const { return x.rotation().inverse() * turn_in_world_; }
  Eigen::Vector3d true_force(const SO3& before, std::int64_t k) const;

  /// Attitude within the path's after so many steps, and what it turns by in step k.
  SO3 cone(double steps) const;
  SO3 coned(std::int64_t k) const;
  /// The mean rate of step k that a gyro reads, where `turn` is that of the path.
  Eigen::Vector3d coning_rate(const Eigen::Vector3d& turn, std::int64_t k) const;

  /// What the shaking adds in step k to height and rate of climb, and to the mean force that is read.
  Eigen::Vector2d shaken(std::int64_t k) const;
  Eigen::Vector3d shaking_force(std::int64_t k) const;

  double dt_s_, radius_m_, speed_m_s_;
  double cone_angle_ = 0.0, cone_rate_ = 0.0;  ///< rad, rad/s
  double shaking_ = 0.0;                       ///< m/s²
  Eigen::Vector3d turn_in_world_;              ///< rad/s
  Input reading_std_, walk_std_;               ///< of one step
  Group::Tangent initial_std_;
  AidingSettings aiding_;
  double velocity_std_;
  std::vector<Eigen::Vector3d> landmarks_;
  double process_scale_, measurement_scale_;
  RunLayout layout_;
};

}  // namespace credence::internal
