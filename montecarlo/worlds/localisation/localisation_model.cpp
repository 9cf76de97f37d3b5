#include "montecarlo/worlds/localisation/localisation_model.h"

#include <numbers>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence::internal {
namespace {

/// At equal angles on a circle about that of the path, half as large again. The vehicle starts at the origin,
/// on its way along the first axis as far as it believes, and turns left.
std::vector<Eigen::Vector2d> known_landmarks_of(const Scenario& scenario) {
  const double radius = scenario.world.path_radius;
  const Index count = integer_value(scenario, "world.known_landmarks");
  std::vector<Eigen::Vector2d> landmarks;
  for (Index i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    landmarks.push_back(Eigen::Vector2d(0.0, radius) + 1.5 * radius * SO2(angle).matrix().col(0));
  }
  return landmarks;
}

}  // namespace

LocalisationModel::LocalisationModel(const Scenario& scenario)
    : dt_s_(scenario.world.dt),
      control_(scenario.world.speed, 0.0, scenario.world.speed / scenario.world.path_radius),
      control_std_(scenario.noise.speed_std, scenario.noise.speed_std, scenario.noise.turn_rate_std),
      initial_std_(scenario.initial.position_std, scenario.initial.position_std,
                   scenario.initial.heading_std_deg * kRadiansPerDegree),
      aiding_(aiding_settings(scenario)),
      landmarks_(known_landmarks_of(scenario)),
      process_scale_(scenario.filter.process_scale),
      measurement_scale_(scenario.filter.measurement_scale) {
  const Index rows = aiding_.landmarks ? 2 * std::ssize(landmarks_) : 2;
  layout_ = slam_layout({.vehicle = 3, .landmark = 2, .landmarks = 0}, rows, false);
  const double std = aiding_.landmarks ? aiding_.relative_std : aiding_.position_std;
  layout_.sensors.front().variances.assign(2, measurement_scale_ * std * std);
}

SE2 LocalisationModel::step(const SE2& x, std::int64_t, NoiseDraw&) const { return x * increment(control_); }

LocalisationModel::Input LocalisationModel::input(const SE2&, std::int64_t, NoiseDraw& noise) const {
  return control_ + control_std_.cwiseProduct(Input(noise.normals(3)));
}

std::optional<Aiding> LocalisationModel::measure(const SE2& x, std::int64_t k, NoiseDraw& noise) const {
  const auto noisy = [](const Eigen::Vector2d& exact, double std, NoiseDraw& draw) {
    return Vector(exact + std * draw.normals(2));
  };
  return drawn_aiding(
      aiding_, k, std::ssize(landmarks_), noise,
      [&](NoiseDraw& draw) { return noisy(x.translation(), aiding_.position_std, draw); },
      [&](Index i, NoiseDraw& draw) {
        const Eigen::Vector2d& l = landmarks_[static_cast<std::size_t>(i)];
        return noisy(x.rotation().inverse() * (l - x.translation()), aiding_.relative_std, draw);
      });
}

ChartedMotion<SE2> LocalisationModel::motion(const SE2& x, const Input& u) const {
  // x Exp(ξ) U = x U Exp(Ad_U⁻¹ ξ); noise of v acts before the turn of the step.
  const SE2 U = increment(u), back = U.inverse();
  SE2::Jacobian G = dt_s_ * SE2::Jacobian::Identity();
  G.topLeftCorner<2, 2>() = dt_s_ * back.rotation().matrix();
  const Input variances = process_scale_ * control_std_.cwiseAbs2();
  return {x * U, back.adjoint(), G * variances.asDiagonal() * G.transpose()};
}

ChartedInnovation<SE2> LocalisationModel::innovation(const SE2& x, const Aiding& seen) const {
  const Index m = seen.z.size();
  ChartedInnovation<SE2> result;
  result.nu = seen.z;
  result.H.setZero(m, 3);
  const double std = aiding_.landmarks ? aiding_.relative_std : aiding_.position_std;
  result.R = measurement_scale_ * std * std * Matrix::Identity(m, m);
  if (!aiding_.landmarks) {
    result.nu -= x.translation();
    result.H.leftCols<2>() = x.rotation().matrix();
    return result;
  }
  for (std::size_t i = 0; i < seen.landmarks.size(); ++i) {
    const Eigen::Vector2d& l = landmarks_[static_cast<std::size_t>(seen.landmarks[i])];
    const Eigen::Vector2d z = x.rotation().inverse() * (l - x.translation());
    const Index row = 2 * static_cast<Index>(i);
    result.nu.segment<2>(row) -= z;
    result.H.middleRows<2>(row) << -Eigen::Matrix2d::Identity(), -quarter_turn(z);
  }
  return result;
}

}  // namespace credence::internal
