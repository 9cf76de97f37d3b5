#include "montecarlo/worlds/spatial_slam/spatial_world.h"

#include <cmath>
#include <numbers>

#include "core/manifold/angle.h"
#include "core/manifold/chart.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"

namespace credence::internal {
namespace {

/// The path of a scenario by the angle of its ellipse.
class Ellipse {
 public:
  explicit Ellipse(const Scenario& s)
      : half_(0.5 * Eigen::Vector3d(real_value(s, "world.path_length"), real_value(s, "world.path_width"),
                                    real_value(s, "world.path_height"))) {}

  Eigen::Vector3d position(double angle) const {
    return half_.cwiseProduct(Eigen::Vector3d(cosine(angle), sine(angle), sine(2.0 * angle)));
  }
  /// Looks along the path, its second axis level.
  SE3 pose(double angle) const {
    const Eigen::Vector3d way =
        half_.cwiseProduct(Eigen::Vector3d(-sine(angle), cosine(angle), 2.0 * cosine(2.0 * angle)));
    Eigen::Matrix3d R;
    R.col(0) = way.normalized();
    R.col(1) = Eigen::Vector3d::UnitZ().cross(way).normalized();
    R.col(2) = R.col(0).cross(R.col(1));
    return {SO3(Eigen::Quaterniond(R)), position(angle)};
  }

 private:
  Eigen::Vector3d half_;
};

/// Evenly in a ball about a point of the path drawn evenly in its angle.
std::vector<Eigen::Vector3d> draw_landmarks(const Scenario& scenario, const Ellipse& path) {
  const NoiseSource source(static_cast<std::uint64_t>(integer_value(scenario, "world.map")), 0);
  const double spread = real_value(scenario, "world.landmark_spread");
  std::vector<Eigen::Vector3d> landmarks;
  for (Index i = 0; i < scenario.world.landmarks; ++i) {
    const auto share = [&](Index slot) { return source.uniform(0, 1, NoisePurpose::world, 4 * i + slot); };
    const double angle = 2.0 * std::numbers::pi * share(0), around = 2.0 * std::numbers::pi * share(1);
    const double height = 2.0 * share(2) - 1.0, flat = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d direction(flat * cosine(around), flat * sine(around), height);
    landmarks.emplace_back(path.position(angle) + spread * std::cbrt(share(3)) * direction);
  }
  return landmarks;
}

std::vector<SpatialWorld::Exact> seen_from(const SE3& pose, const SpatialWorld& world,
                                           const WorldSettings& sensor) {
  const double widest = cosine(0.5 * std::min(sensor.field_of_view_deg, 360.0) * kRadiansPerDegree);
  const SE3 back = pose.inverse();
  std::vector<SpatialWorld::Exact> seen;
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    const Eigen::Vector3d z = back.rotation() * world.landmarks[i] + back.translation();
    const double range = z.norm();
    if (range < sensor.sensor_min_range || range > sensor.sensor_range || z[0] < widest * range) continue;
    seen.push_back({static_cast<int>(i), z});
  }
  return seen;
}

}  // namespace

Eigen::Vector3d SpatialWorld::squares(const Eigen::Vector3d& v) const {
  return by_length ? Eigen::Vector3d(Eigen::Vector3d::Constant(v.squaredNorm()))
                   : Eigen::Vector3d(v.cwiseAbs2());
}

SpatialWorld make_spatial_world(const Scenario& scenario) {
  const Ellipse path(scenario);
  SpatialWorld world;
  const double loop = real_value(scenario, "world.loop_steps");
  const double odometry_noise = real_value(scenario, "noise.odometry_share");
  world.by_length = word_value(scenario, "noise.share_of") == "length";
  for (std::int64_t k = 0; k <= scenario.study.steps; ++k) {
    world.path.push_back(path.pose(2.0 * std::numbers::pi * static_cast<double>(k) / loop));
    if (k == 0) continue;
    const SE3 step = world.path[static_cast<std::size_t>(k - 1)].inverse() * world.path.back();
    SpatialControl control{step.translation(), step.rotation().Log(), {}};
    control.variances << world.squares(control.v), world.squares(control.omega);
    control.variances *= odometry_noise * odometry_noise;
    world.controls.push_back(control);
  }
  world.landmarks = draw_landmarks(scenario, path);
  for (const SE3& pose : world.path) world.in_view.push_back(seen_from(pose, world, scenario.world));
  world.landmark_noise = real_value(scenario, "noise.landmark_share");
  world.initial_std << Eigen::Vector3d::Constant(scenario.initial.position_std),
      Eigen::Vector3d::Constant(scenario.initial.heading_std_deg * kRadiansPerDegree);
  world.process_scale = scenario.filter.process_scale;
  world.measurement_scale = scenario.filter.measurement_scale;
  world.detection_probability = scenario.noise.detection_probability;
  world.measurement_delay = measurement_delay(scenario);
  world.width_m = real_value(scenario, "world.path_length") + real_value(scenario, "world.path_width");
  return world;
}

RunLayout spatial_layout(const SpatialWorld& world) {
  std::size_t most = 0;
  for (const auto& seen : world.in_view) most = std::max(most, seen.size());
  RunLayout layout;
  for (const char* name :
       {"position.x", "position.y", "position.z", "attitude.x", "attitude.y", "attitude.z"}) {
    layout.states.emplace_back(name);
  }
  layout.angles.assign(layout.states.size(), false);
  layout.units = {"m", "m", "m", "rad", "rad", "rad"};
  layout.blocks = {{"position", Part::position, {0, 1, 2}}, {"attitude", Part::heading, {3, 4, 5}}};
  layout.sensors = {{.name = "", .dim = 3 * static_cast<Index>(most), .piece = 3}};
  layout.nonlinear = true;
  return layout;
}

SpatialSimulation::SpatialSimulation(const SpatialWorld& world, const NoiseSource& source)
    : world_(world),
      source_(source),
      draws_(source, 6, 3, std::ssize(world.landmarks), world.detection_probability,
             world.measurement_delay) {}

SE3 SpatialSimulation::start(std::int64_t run) {
  draws_.start(run);
  Eigen::Matrix<double, 6, 1> error;
  source_.normals(run, 0, NoisePurpose::initial, {error.data(), 6});
  error = error.cwiseProduct(world_.initial_std);
  return plus(world_.path.front(), SE3::Tangent(error), Chart::componentwise_left);
}

SpatialControl SpatialSimulation::read(std::size_t k) {
  using Six = Eigen::Matrix<double, 6, 1>;
  SpatialControl control = world_.controls[k - 1];
  const Six noise = control.variances.cwiseSqrt().cwiseProduct(Eigen::Map<const Six>(draws_.motion(k)));
  control.v += noise.head<3>();
  control.omega += noise.tail<3>();
  control.variances *= world_.process_scale;
  return control;
}

std::span<const SpatialObservation> SpatialSimulation::observe(std::size_t k) {
  const double* noise = draws_.measurement(k);
  const double* seen = draws_.detection(k);
  return draws_.in_time([&](auto& observations) {
    for (const SpatialWorld::Exact& exact : world_.in_view[k]) {
      if (seen[exact.landmark] == 0.0) continue;
      const Eigen::Vector3d variances = world_.landmark_variances(exact.z);
      const Eigen::Map<const Eigen::Vector3d> of_landmark(noise + 3 * exact.landmark);
      observations.push_back({exact.landmark, exact.z + variances.cwiseSqrt().cwiseProduct(of_landmark),
                              world_.measurement_scale * variances});
    }
  });
}

}  // namespace credence::internal
