#include "montecarlo/worlds/planar/planar_bound.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "tests/core/models/numerical_jacobian.h"

namespace credence::internal {
namespace {

Scenario bounded_planar(const std::vector<std::string>& overrides) {
  std::vector<std::string> all = {"study.steps=25",
                                  "world.landmarks=5",
                                  "noise.speed_std=1e-5",
                                  "noise.range_std=1e-4",
                                  "noise.bearing_std_deg=1e-3",
                                  "initial.position_std=1e-5",
                                  "initial.heading_std_deg=1e-3"};
  if (std::ranges::find(overrides, "world.vehicle=car") == overrides.end()) {
    all.emplace_back("noise.turn_rate_std=2e-5");
  }
  all.insert(all.end(), overrides.begin(), overrides.end());
  return load_scenario_text("[world]\nmodel = \"planar\"\n", "t.toml", all);
}

/// The bound without any recursion, for noise so small that all truths are the nominal one: the start, the
/// noises of all controls and the landmarks that are states are the unknowns; every observation so far adds
/// p Hᵀ R⁻¹ H, by differences of the model, and the inverse is taken to the pose. Position, heading, and all
/// landmarks a landmark, NaN until all are known.
std::array<double, 3> planar_bound_in_one_batch(const Scenario& scenario, std::size_t steps) {
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  const auto path = static_cast<Index>(3 + 2 * steps);
  const Index unknowns = path + 2 * world.states();
  const auto pose_of = [&](const Vector& y, std::size_t k) {
    Pose pose = world.start + y.head<3>();
    for (std::size_t j = 0; j < k; ++j) {
      const Control u = world.controls[j] + y.segment<2>(3 + 2 * static_cast<Index>(j));
      pose = world.vehicle.moved(pose, u, world.dt_s);
    }
    return pose;
  };
  Vector truth = Vector::Zero(unknowns);
  for (Index i = 0; i < world.states(); ++i) {
    truth.segment<2>(path + 2 * i) = world.landmarks[static_cast<std::size_t>(i)];
  }
  Matrix information = Matrix::Zero(unknowns, unknowns);
  information.diagonal().head<3>() = noise.initial_std.cwiseAbs2().cwiseInverse();
  for (std::size_t j = 0; j < steps; ++j) {
    information.diagonal().segment<2>(3 + 2 * static_cast<Index>(j)) =
        noise.control_std.cwiseAbs2().cwiseInverse();
  }
  for (std::size_t k = 1; k <= steps; ++k) {
    for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
      if (!world.sees(measure_range_bearing(pose_of(truth, k), world.landmarks[i]))) continue;
      const bool is_state = static_cast<Index>(i) < world.states();
      const auto measured = [&](const Vector& y) {
        const Point at =
            is_state ? Point(y.segment<2>(path + 2 * static_cast<Index>(i))) : world.landmarks[i];
        return Vector(measure_range_bearing(pose_of(y, k), at));
      };
      const Matrix H = numerical_jacobian(measured, truth);
      information += scenario.noise.detection_probability * H.transpose() *
                     noise.measurement_std.cwiseAbs2().cwiseInverse().asDiagonal() * H;
    }
  }
  std::vector<Index> known;
  for (Index i = 0; i < unknowns; ++i) {
    if (information(i, i) > 0.0) known.push_back(i);
  }
  const Matrix covariance = Matrix(information(known, known)).inverse();
  const auto to_pose = [&](const Vector& y) { return Vector(pose_of(y, steps)); };
  const Matrix J = numerical_jacobian(to_pose, truth)(Eigen::all, known);
  const Matrix P = J * covariance * J.transpose();
  const Index landmarks = std::ssize(known) - path;
  return {P(0, 0) + P(1, 1), P(2, 2),
          std::ssize(known) == unknowns && landmarks > 0
              ? 2.0 * covariance.diagonal().tail(landmarks).sum() / static_cast<double>(landmarks)
              : std::nan("")};
}

void expect_planar_batch(const std::vector<std::string>& overrides, bool whole_map = true) {
  const Scenario scenario = bounded_planar(overrides);
  const PosteriorBound bound = planar_bound(scenario);
  ASSERT_EQ(bound.reason, "");
  EXPECT_EQ(bound.runs, kBoundRuns);
  for (const std::size_t k : {1U, 8U, 25U}) {
    const auto [position, heading, map] = planar_bound_in_one_batch(scenario, k);
    EXPECT_NEAR(bound.find("position")->bound[k - 1] / position, 1.0, 1e-4) << k;
    EXPECT_NEAR(bound.find("heading")->bound[k - 1] / heading, 1.0, 1e-4) << k;
    EXPECT_NEAR(bound.find("position")->at_truth[k - 1] / position, 1.0, 1e-4) << k;
    const double all = bound.find("all landmarks")->bound[k - 1];
    EXPECT_EQ(std::isnan(all), std::isnan(map)) << k;
    if (!std::isnan(map)) {
      EXPECT_NEAR(all / map, 1.0, 1e-4) << k;
    }
    if (k == 25) {
      EXPECT_EQ(std::isnan(all), !whole_map);
    }
  }
}

TEST(PlanarBound, IsThatOfAllNoisesAndLandmarksInOneBatch) { expect_planar_batch({}); }

TEST(PlanarBound, OfACarWithAnchors) {
  expect_planar_batch(
      {"world.vehicle=car", "noise.steering_std_deg=1e-3", "world.observability=full", "world.anchors=2"});
}

TEST(PlanarBound, OfLandmarksThatComeIntoView) {
  expect_planar_batch({"world.sensor_range=6", "world.landmarks=8"}, false);
}

// A mean over truths of what was seen is that over events: 64 truths have every landmark often enough that
// the information of a step is within some per cent of its share.
TEST(PlanarBound, MissedObservationsTellTheirShare) {
  const Scenario scenario = bounded_planar({"noise.detection_probability=0.5"});
  const PosteriorBound bound = planar_bound(scenario);
  const auto [position, heading, map] = planar_bound_in_one_batch(scenario, 25);
  EXPECT_NEAR(bound.find("position")->bound.back() / position, 1.0, 0.05);
  EXPECT_NEAR(bound.find("all landmarks")->bound.back() / map, 1.0, 0.05);
  const double whole = planar_bound(bounded_planar({})).find("all landmarks")->bound.back();
  EXPECT_GT(bound.find("all landmarks")->bound.back(), 1.02 * whole);
}

TEST(PlanarBound, WhatTheFilterBelievesIsNoMatter) {
  const auto mean = [](const std::vector<std::string>& overrides) {
    return planar_bound(bounded_planar(overrides)).find("position")->mean_bound();
  };
  EXPECT_EQ(mean({}), mean({"filter.process_scale=4", "filter.measurement_scale=0.1"}));
}

TEST(PlanarBound, AWorldTooLargeHasAReasonThatNamesItsSize) {
  EXPECT_THAT(planar_bound(bounded_planar({"world.landmarks=3000"})).reason,
              testing::HasSubstr("3000 landmarks and 25 steps are too many"));
  EXPECT_EQ(planar_bound(bounded_planar({"noise.bearing_std_deg=0"})).reason, kBoundOfNoisyMeasurements);
}

}  // namespace
}  // namespace credence::internal
