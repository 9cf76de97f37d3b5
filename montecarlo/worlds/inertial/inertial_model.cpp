#include "montecarlo/worlds/inertial/inertial_model.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/scenario/key_fields.h"

namespace credence::internal {
namespace {

using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Vector3 kGravity(0.0, 0.0, -9.82);  // m/s², as in [Brossard 2020]

Vector6 pair(double first, double second) {
  return (Vector6() << Vector3::Constant(first), Vector3::Constant(second)).finished();
}

RunLayout layout_of(const AidingSettings& aiding, double velocity_std, double scale, Index landmarks) {
  constexpr std::pair<const char*, const char*> kBlocks[] = {{"position", "m"},
                                                             {"velocity", "m/s"},
                                                             {"attitude", "rad"},
                                                             {"gyro_bias", "rad/s"},
                                                             {"accelerometer_bias", "m/s²"}};
  std::vector<std::string> states, units;
  for (const auto& [block, unit] : kBlocks) {
    for (const char* axis : {".x", ".y", ".z"}) {
      states.push_back(std::string(block) + axis);
      units.emplace_back(unit);
    }
  }
  for (std::size_t i = 6; i < 9; ++i) states[i] += ":angle";
  RunLayout layout = model_layout(states, {{"", aiding.landmarks ? 3 * landmarks : 6}});
  layout.units = std::move(units);
  layout.blocks.front().part = Part::position;
  layout.nonlinear = true;
  Sensor& sensor = layout.sensors.front();
  sensor.piece = aiding.landmarks ? 3 : 6;
  const double std = aiding.landmarks ? aiding.relative_std : aiding.position_std;
  sensor.variances.assign(3, scale * std * std);
  if (!aiding.landmarks)
    sensor.variances.insert(sensor.variances.end(), 3, scale * velocity_std * velocity_std);
  return layout;
}

}  // namespace

InertialModel::InertialModel(const Scenario& scenario)
    : dt_s_(scenario.world.dt),
      radius_m_(scenario.world.path_radius),
      speed_m_s_(scenario.world.speed),
      turn_in_world_(Vector3::Zero()),
      aiding_(aiding_settings(scenario)),
      velocity_std_(real_value(scenario, "noise.velocity_std")),
      // Those of [Brossard 2020] on a circle of 5 m.
      landmarks_{radius_m_ * Vector3(0.0, 0.4, 0.4), radius_m_ * Vector3(-0.4, -0.4, -0.4),
                 radius_m_ * Vector3(0.4, -0.4, -0.4)},
      process_scale_(scenario.filter.process_scale),
      measurement_scale_(scenario.filter.measurement_scale) {
  const auto real = [&](const char* path) { return real_value(scenario, path); };
  if (word_value(scenario, "world.attitude") == "along_path") {
    turn_in_world_[2] = -speed_m_s_ / radius_m_;
  }
  cone_angle_ = real("world.coning_angle_deg") * kRadiansPerDegree;
  cone_rate_ = 2.0 * std::numbers::pi * real("world.coning_frequency");
  shaking_ = cone_angle_ > 0.0 ? real("world.sculling_acceleration") : 0.0;
  // A density is that of white noise in continuous time: a mean over dt has the variance density²/dt.
  reading_std_ = pair(real("noise.gyro_density"), real("noise.accelerometer_density")) / std::sqrt(dt_s_);
  walk_std_ = pair(real("noise.gyro_bias_walk"), real("noise.accelerometer_bias_walk")) * std::sqrt(dt_s_);
  initial_std_ << pair(scenario.initial.position_std, real("initial.velocity_std")),
      Vector3::Constant(real("initial.attitude_std_deg") * kRadiansPerDegree),
      pair(real("initial.gyro_bias_std"), real("initial.accelerometer_bias_std"));
  layout_ = layout_of(aiding_, velocity_std_, measurement_scale_, std::ssize(landmarks_));
}

// Clockwise from the top of the circle, level, x forward.
InertialModel::Group InertialModel::start() const {
  SE23::Vectors vectors;
  vectors << Vector3(0.0, radius_m_, 0.0), Vector3(speed_m_s_, 0.0, 0.0);
  return {SE23(SO3(), vectors), VectorGroup<6>()};
}

SE23 InertialModel::moved(const SE23& x, const Vector3& rate, const Vector3& force) const {
  const Vector3 a = x.rotation() * force + kGravity;
  SE23::Vectors vectors;
  vectors << x.translation() + dt_s_ * x.velocity() + 0.5 * dt_s_ * dt_s_ * a, x.velocity() + dt_s_ * a;
  return {x.rotation() * SO3::Exp(dt_s_ * rate), vectors};
}

/// Of the centripetal acceleration in the middle of step k.
Vector3 InertialModel::true_force(const SO3& before, std::int64_t k) const {
  const double rate = speed_m_s_ / radius_m_, angle = rate * dt_s_ * (static_cast<double>(k) - 0.5);
  const Vector3 a = -rate * speed_m_s_ * Vector3(sine(angle), cosine(angle), 0.0);
  return before.inverse() * Vector3(a - kGravity);
}

SO3 InertialModel::cone(double steps) const {
  const double angle = cone_rate_ * dt_s_ * steps;
  return SO3::Exp(cone_angle_ * Vector3(cosine(angle), sine(angle), 0.0));
}

SO3 InertialModel::coned(std::int64_t k) const {
  const auto end = static_cast<double>(k);
  return cone(end - 1.0).inverse() * cone(end);
}

/// Of Exp(θ n), n on a circle, the rate is sin θ ṅ − (1 − cos θ) n × ṅ. The turn of the path is seen from an
/// axis that moves within the step: Simpson's rule.
Vector3 InertialModel::coning_rate(const Vector3& turn, std::int64_t k) const {
  const auto end = static_cast<double>(k);
  const double from = cone_rate_ * dt_s_ * (end - 1.0), to = cone_rate_ * dt_s_ * end;
  const Vector3 moved(cosine(to) - cosine(from), sine(to) - sine(from), 0.0);
  const Vector3 own =
      sine(cone_angle_) / dt_s_ * moved - (1.0 - cosine(cone_angle_)) * cone_rate_ * Vector3::UnitZ();
  const SO3 start = cone(end - 1.0);
  const Vector3 middle = (cone(end - 0.5).inverse() * start) * turn, last = coned(k).inverse() * turn;
  return own + (turn + 4.0 * middle + last) / 6.0;
}

/// Of v = B/Ω sin Ωt and p = B/Ω² (1 − cos Ωt), less what v adds to p by itself.
Eigen::Vector2d InertialModel::shaken(std::int64_t k) const {
  const double from = cone_rate_ * dt_s_ * static_cast<double>(k - 1), to = from + cone_rate_ * dt_s_;
  const double speed = shaking_ / cone_rate_;
  return {speed / cone_rate_ * (cosine(from) - cosine(to)) - dt_s_ * speed * sine(from),
          speed * (sine(to) - sine(from))};
}

/// The mean over the step of B cos Ωt Exp(θ n)ᵀ e_z, n = (cos Ωt, sin Ωt, 0): Exp(θ n)ᵀ e_z = cos θ e_z −
/// sin θ n × e_z. The path turns about e_z.
Vector3 InertialModel::shaking_force(std::int64_t k) const {
  const double turn = cone_rate_ * dt_s_;
  const double from = turn * static_cast<double>(k - 1), to = turn * static_cast<double>(k);
  const double cos = (sine(to) - sine(from)) / turn;
  const double sin_cos = 0.5 * (sine(to) * sine(to) - sine(from) * sine(from)) / turn;
  const double cos_cos = 0.5 + 0.5 * (sine(to) * cosine(to) - sine(from) * cosine(from)) / turn;
  const double tilt = sine(cone_angle_);
  return shaking_ * Vector3(-tilt * sin_cos, tilt * cos_cos, cosine(cone_angle_) * cos);
}

InertialModel::Group InertialModel::step(const Group& x, std::int64_t k, NoiseDraw& noise) const {
  const Vector6 walk = walk_std_.cwiseProduct(Vector6(noise.normals(6)));
  const SE23& body = x.first();
  SE23 next = moved(body, true_rate(body), true_force(body.rotation(), k));
  if (cone_angle_ > 0.0) {
    SE23::Vectors vectors = next.vectors();
    vectors.row(2) += shaken(k).transpose();
    next = {next.rotation() * coned(k), vectors};
  }
  return {next, VectorGroup<6>(x.second().vector() + walk)};
}

// The rate is the same before and after the step, as the turn is about a fixed axis; the force acted before.
InertialModel::Input InertialModel::input(const Group& x, std::int64_t k, NoiseDraw& noise) const {
  SO3 after = x.first().rotation();
  if (cone_angle_ > 0.0) after = after * coned(k).inverse();
  const Vector3 rate = after.inverse() * turn_in_world_;
  const SO3 before = after * SO3::Exp(-dt_s_ * rate);
  Input reading;
  reading << rate, true_force(before, k);
  if (cone_angle_ > 0.0) {
    reading.head<3>() = coning_rate(rate, k);
    reading.tail<3>() += shaking_force(k);
  }
  return reading + x.second().vector() + reading_std_.cwiseProduct(Input(noise.normals(6)));
}

std::optional<Aiding> InertialModel::measure(const Group& x, std::int64_t k, NoiseDraw& noise) const {
  const SE23& body = x.first();
  return drawn_aiding(
      aiding_, k, std::ssize(landmarks_), noise,
      [&](NoiseDraw& draw) {
        Vector z(6);
        z << body.translation(), body.velocity();
        return Vector(z + pair(aiding_.position_std, velocity_std_).cwiseProduct(draw.normals(6)));
      },
      [&](Index i, NoiseDraw& draw) {
        const Vector3& l = landmarks_[static_cast<std::size_t>(i)];
        const Vector3 z = body.rotation().inverse() * Vector3(l - body.translation());
        return Vector(z + aiding_.relative_std * draw.normals(3));
      });
}

/// By right perturbations (ρ, ν, φ; β_g, β_a) and with D = Exp(ω dt)ᵀ, J = J_r(ω dt): φ⁺ = D φ − J dt β_g,
/// ν⁺ = D (ν − dt f^ φ − dt β_a), ρ⁺ = D (ρ + dt ν − dt²/2 f^ φ − dt²/2 β_a); noise of the readings enters as
/// the biases do, and the walk of the biases before all this.
ChartedMotion<InertialModel::Group> InertialModel::motion(const Group& x, const Input& u) const {
  using Matrix3 = Eigen::Matrix3d;
  const Vector6 reading = u - x.second().vector();
  const Vector3 rate = reading.head<3>(), force = reading.tail<3>();
  const Matrix3 D = SO3::Exp(-dt_s_ * rate).matrix();
  const double t = dt_s_, half = 0.5 * dt_s_ * dt_s_;
  const Matrix3 turned = -D * cross_matrix(force);
  ChartedMotion<Group> result;
  result.moved = {moved(x.first(), rate, force), x.second()};
  Eigen::Matrix<double, 9, 6> B = Eigen::Matrix<double, 9, 6>::Zero();  // of the biases
  B.block<3, 3>(0, 3) = -half * D;
  B.block<3, 3>(3, 3) = -t * D;
  B.block<3, 3>(6, 0) = -t * right_jacobian<SO3>(t * rate);
  auto& F = result.F;
  F.setIdentity();
  for (int i = 0; i < 9; i += 3) F.block<3, 3>(i, i) = D;
  F.block<3, 3>(0, 3) = t * D;
  F.block<3, 3>(0, 6) = half * turned;
  F.block<3, 3>(3, 6) = t * turned;
  F.topRightCorner<9, 6>() = B;
  const Vector6 walk = process_scale_ * walk_std_.cwiseAbs2();
  result.Q = F.rightCols<6>() * walk.asDiagonal() * F.rightCols<6>().transpose();
  const Vector6 noise = process_scale_ * reading_std_.cwiseAbs2();
  result.Q.topLeftCorner<9, 9>() += B * noise.asDiagonal() * B.transpose();
  return result;
}

ChartedInnovation<InertialModel::Group> InertialModel::innovation(const Group& x, const Aiding& seen) const {
  const SE23& body = x.first();
  const Index m = seen.z.size();
  ChartedInnovation<Group> result;
  result.nu = seen.z;
  result.H.setZero(m, Group::kDim);
  if (!aiding_.landmarks) {
    const Eigen::Matrix3d R = body.rotation().matrix();
    result.nu.head<3>() -= body.translation();
    result.nu.tail<3>() -= body.velocity();
    result.H.block<3, 3>(0, 0) = R;
    result.H.block<3, 3>(3, 3) = R;
    result.R = measurement_scale_ * pair(aiding_.position_std, velocity_std_).cwiseAbs2().asDiagonal();
    return result;
  }
  result.R = measurement_scale_ * aiding_.relative_std * aiding_.relative_std * Matrix::Identity(m, m);
  for (std::size_t i = 0; i < seen.landmarks.size(); ++i) {
    const Vector3& l = landmarks_[static_cast<std::size_t>(seen.landmarks[i])];
    const Vector3 z = body.rotation().inverse() * Vector3(l - body.translation());
    const Index row = 3 * static_cast<Index>(i);
    result.nu.segment<3>(row) -= z;
    result.H.block<3, 3>(row, 0) = -Eigen::Matrix3d::Identity();
    result.H.block<3, 3>(row, 6) = cross_matrix(z);
  }
  return result;
}

}  // namespace credence::internal
