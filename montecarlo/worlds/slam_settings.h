#pragma once

#include <string>
#include <vector>

#include "core/inflation/inflation_rule.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/world_schema.h"

/// @file
/// What the SLAM worlds, on a line and in the plane, have in common: landmarks, of which some may be known,
/// and a filter whose covariance may be inflated.

namespace credence::internal {

struct EstimatorOffer;

/// Their rows of [world] and [filter].
std::vector<KeyRow> slam_keys();

/// The rows process_scale and measurement_scale of [filter], which every world has.
KeyRow process_scale_key();
KeyRow measurement_scale_key();

/// Refuses a world without anything to see.
void check_landmarks(const Scenario& scenario, const Refusal& refuse);

/// Refuses a sensor that sees nothing, near or far.
void check_sensor_range(const Scenario& scenario, const Refusal& refuse);

/// Refuses an inflation that there is not.
void check_inflation(const Scenario& scenario, const Refusal& refuse);

/// Refuses an estimator of another world, a world without landmarks, and a sensor that sees nothing.
void check_contested_slam(const Scenario& scenario, const Refusal& refuse, const EstimatorOffer& offer);

/// A pose and points in the plane.
BlockLayout plane_slam_blocks(const Scenario& scenario);

/// The inflation that [filter] asks for; of `rank`, the constant ΔP for the complete map.
InflationRule make_inflation_rule(const Scenario& scenario);

/// "monobot, 2 landmarks, partially observable".
std::string slam_text(const Scenario& scenario);

/// "world.landmarks = 2, world.anchors = 0".
std::string slam_size_text(const Scenario& scenario);

/// "world.landmarks = 2", where there are no anchors.
std::string landmarks_size_text(const Scenario& scenario);

}  // namespace credence::internal
