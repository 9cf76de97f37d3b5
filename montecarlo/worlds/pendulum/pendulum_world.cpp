#include "montecarlo/worlds/pendulum/pendulum_world.h"

#include <fmt/format.h>

#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_keys.h"
#include "montecarlo/worlds/plugged/function_bound.h"
#include "montecarlo/worlds/plugged/function_ukf.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"
#include "montecarlo/worlds/slam_settings.h"
#include "montecarlo/worlds/world_list.h"

namespace credence::internal {
namespace {

constexpr double kGravity_m_s2 = 9.81, kLength_m = 1.0;

std::vector<KeyRow> pendulum_keys() {
  return {
      planar_row("world", "dt"),
      own_row("world", "start_angle_deg", "deg", "angle from the vertical at the start, as believed", 90.0),
      own_row("noise", "angular_acceleration_density", "rad^2/s^3",
              "power spectral density of the white noise that drives the pendulum", 0.01),
      {"noise", "displacement_std", "", "standard deviation of the measured sine of the angle",
       own_real("noise.displacement_std", 0.31622776601683794, Interval::kPositive)},
      own_row("initial", "angle_std_deg", "deg", "standard deviation of the angle at the start", 18.0),
      own_row("initial", "angular_velocity_std", "rad/s",
              "standard deviation of the angular velocity at the start", 0.3),
      {"filter", "moments", "",
       "how mean and covariance pass the functions: jacobian, extended Kalman filter; sigma_points, "
       "unscented "
       "Kalman filter",
       own_choice("filter.moments", {"jacobian", "sigma_points"})},
      process_scale_key(),
      measurement_scale_key(),
  };
}

void set_pendulum_defaults(Scenario& scenario) {
  scenario.world.dt = 0.01;
  scenario.study.steps = 500;
}

BlockLayout pendulum_blocks(const Scenario&) { return {.vehicle = 2, .landmark = 0, .landmarks = 0}; }

bool is_unscented(const Scenario& scenario) {
  return word_value(scenario, "filter.moments") == "sigma_points";
}

std::string pendulum_text(const Scenario& scenario) {
  return fmt::format("pendulum, its displacement measured{}{}, {} Kalman filter", detection_text(scenario),
                     noise_switches_text(scenario), is_unscented(scenario) ? "unscented" : "extended");
}

std::unique_ptr<Experiment> pendulum_experiment(const Scenario& scenario) {
  const FunctionModel truth = pendulum_model(scenario);
  FunctionModel believed = truth;
  believed.Q *= scenario.filter.process_scale;
  believed.R *= scenario.filter.measurement_scale;
  const MissingWorld world(FunctionWorld(truth), scenario.noise.detection_probability);
  if (is_unscented(scenario)) {
    return plugged_experiment(
        world, [=] { return FunctionUkf(believed); }, plug_settings(scenario));
  }
  return plugged_experiment(
      world, [=] { return FunctionEkf(believed); }, plug_settings(scenario));
}

PosteriorBound pendulum_bound(const Scenario& scenario) {
  return posterior_bound(pendulum_model(scenario), plug_settings(scenario),
                         scenario.noise.detection_probability);
}

}  // namespace

FunctionModel pendulum_model(const Scenario& scenario) {
  const double dt = scenario.world.dt, rate = kGravity_m_s2 / kLength_m;
  const double q = real_value(scenario, "noise.angular_acceleration_density");
  const double displacement = real_value(scenario, "noise.displacement_std");
  const double angle = real_value(scenario, "initial.angle_std_deg") * kRadiansPerDegree;
  const double velocity = real_value(scenario, "initial.angular_velocity_std");
  FunctionModel model;
  model.f = [=](const Vector& x) {
    return Vector(Eigen::Vector2d(x[0] + x[1] * dt, x[1] - rate * sine(x[0]) * dt));
  };
  model.h = [](const Vector& x) { return Vector::Constant(1, sine(x[0])).eval(); };
  model.F = [=](const Vector& x) {
    return Matrix((Matrix(2, 2) << 1.0, dt, -rate * cosine(x[0]) * dt, 1.0).finished());
  };
  model.H = [](const Vector& x) { return Matrix((Matrix(1, 2) << cosine(x[0]), 0.0).finished()); };
  model.Q = Matrix(2, 2);
  model.Q << dt * dt * dt / 3.0, dt * dt / 2.0, dt * dt / 2.0, dt;
  model.Q *= q;
  model.R = Matrix::Constant(1, 1, displacement * displacement);
  model.mean = Eigen::Vector2d(real_value(scenario, "world.start_angle_deg") * kRadiansPerDegree, 0.0);
  model.P0 = Eigen::Vector2d(angle * angle, velocity * velocity).asDiagonal();
  model.states = {"angle:angle", "angular_velocity"};
  model.units = {"rad", "rad/s"};
  return model;
}

constinit const World kPendulumWorld = {.schema = {.name = "pendulum",
                                                   .meaning = "pendulum, by Jacobians or sigma points",
                                                   .keys = pendulum_keys,
                                                   .set_defaults = set_pendulum_defaults,
                                                   .blocks = pendulum_blocks},
                                        .experiment = pendulum_experiment,
                                        .text = pendulum_text,
                                        .figure = RunFigure::states,
                                        .posterior_bound = pendulum_bound};

}  // namespace credence::internal
