#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/manifold/angle.h"
#include "datasets/replay/replay_filter.h"

namespace credence::internal::test {

/// A world in which the filter's assumptions hold: a unicycle on a circle among four landmarks, all in view.
struct ReplayWorld {
  ReplaySettings settings;
  ReplayStart start;
  Vehicle vehicle{VehicleKind::unicycle, {}};

  ReplayWorld() {
    settings.vehicle = VehicleKind::unicycle;
    settings.initial = {.position_std = 0.02, .heading_std_deg = 0.5, .heading_deg = 0};
    settings.noise = {.speed_std = 0.1, .steering_std_deg = 0, .turn_rate_std = 0.05};
    settings.noise.range_std = 0.05;
    settings.noise.bearing_std_deg = 0.5;
    start.survey_m = {{4, 1}, {-3, 4}, {-2, -5}, {5, -4}};
    start.first_seen = {0, 1, 2, 3};
    start.time_s = 100;
  }

  /// One run of the filter with noise from `seed`; the world's range noise is `noise_ratio` times the
  /// assumed.
  ReplayResult run(unsigned seed, int steps, double noise_ratio = 1) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double degree = kRadiansPerDegree;
    Pose truth = start.pose;
    truth(0) += settings.initial.position_std * normal(random);
    truth(1) += settings.initial.position_std * normal(random);
    truth(2) += settings.initial.heading_std_deg * degree * normal(random);
    ReplayFilter filter(settings, start);
    for (int k = 1; k <= steps; ++k) {
      const Control measured(0.5, 0.2);
      Control actual = measured;
      actual(0) += settings.noise.speed_std * normal(random);
      actual(1) += settings.noise.turn_rate_std * normal(random);
      truth = vehicle.moved(truth, actual, 0.1);
      filter.set_control(measured);
      filter.advance_to(start.time_s + 0.1 * k);
      std::vector<LoggedObservation> observations;
      for (std::size_t i = 0; i < start.survey_m.size(); ++i) {
        RangeBearing z = measure_range_bearing(truth, start.survey_m[i]);
        z(0) += noise_ratio * settings.noise.range_std * normal(random);
        z(1) = wrap_angle(z(1) + settings.noise.bearing_std_deg * degree * normal(random));
        observations.push_back({static_cast<int>(i), z});
      }
      filter.observe(start.time_s + 0.1 * k, observations);
      filter.compare_pose(start.time_s + 0.1 * k, truth);
    }
    return filter.finish();
  }
};

}  // namespace credence::internal::test
