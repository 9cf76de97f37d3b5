#pragma once

#include <memory>
#include <vector>

#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/worlds/charted/charted_world.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"

/// @file
/// What the scenario says of a world in a Lie group: what aids the filter, and its charts.

namespace credence::internal {

/// How and how often the world outside is measured.
struct AidingSettings {
  bool landmarks = false;              ///< else by satellite
  Index interval = 1;                  ///< steps from one measurement to the next
  double position_std = 0.0;           ///< m, by satellite
  double relative_std = 0.0;           ///< m, of a landmark's place in the frame of the vehicle
  double detection_probability = 1.0;  ///< of the satellite's fix, or of each landmark
};

/// The rows of every such world: aiding and its noise, charts, scales.
std::vector<KeyRow> charted_keys();
/// Whether landmarks are measured, or satellites.
bool aided_by_landmarks(const Scenario& scenario);
bool aided_by_satellites(const Scenario& scenario);

AidingSettings aiding_settings(const Scenario& scenario);
ChartSettings chart_settings(const Scenario& scenario);

/// "aided by landmarks every 100 steps, error componentwise": a few words for reports.
std::string charted_text(const Scenario& scenario);

/// What is measured at step k: `of_satellites(noise)`, or the landmarks `of_landmark(i, noise)`, i < count;
/// each may be missed.
template <class OfSatellites, class OfLandmark>
std::optional<Aiding> drawn_aiding(const AidingSettings& aiding, std::int64_t k, Index count,
                                   NoiseDraw& noise, const OfSatellites& of_satellites,
                                   const OfLandmark& of_landmark) {
  if (k % aiding.interval != 0) return std::nullopt;
  const auto seen = [&] { return noise.uniform() < aiding.detection_probability; };
  if (!aiding.landmarks) {
    Aiding fix{.z = of_satellites(noise)};
    return seen() ? std::optional(fix) : std::nullopt;
  }
  Aiding batch;
  for (Index i = 0; i < count; ++i) {
    const Vector z = of_landmark(i, noise);
    if (!seen()) continue;
    batch.z.conservativeResize(batch.z.size() + z.size());
    batch.z.tail(z.size()) = z;
    batch.landmarks.push_back(i);
  }
  return batch.landmarks.empty() ? std::nullopt : std::optional(batch);
}

/// Many runs of the filter in the world of a scenario's model.
template <ChartedModel Model>
std::unique_ptr<Experiment> charted_experiment(const Scenario& scenario) {
  const auto model = std::make_shared<const Model>(scenario);
  const ChartSettings charts = chart_settings(scenario);
  return plugged_experiment(
      ChartedWorld<Model>(model, charts.judged), [=] { return ChartedFilter<Model>(model, charts); },
      plug_settings(scenario));
}

}  // namespace credence::internal
