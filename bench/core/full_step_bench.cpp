// One step (predict and update) of EKF-SLAM in large maps.

#include "core/filters/ekf_slam.h"

#include <benchmark/benchmark.h>

#include <numbers>
#include <span>
#include <vector>

namespace credence::internal {
namespace {

using Observations = std::vector<Observation<PlanarModel>>;

/// Starts a filter with all landmarks on rings around it in its map, all of them correlated.
template <class Filter>
Filter planar_filter(int landmarks) {
  const Eigen::Matrix2d Q = Eigen::Vector2d(0.01, 0.0025).asDiagonal();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
  Filter filter({.vehicle = {}, .dt_s = 0.1}, Q, R);
  filter.reset(Pose::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  Observations all;
  for (int i = 0; i < landmarks; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / landmarks;
    all.push_back({i, RangeBearing(10.0 + i % 7, wrap_angle(angle))});
  }
  filter.update(all);
  return filter;
}

/// What the filter expects to see of all landmarks at its start, where it stays.
template <class Filter>
Observations expected_observations(const Filter& filter) {
  Observations z;
  for (const int id : filter.landmarks()) {
    const Point landmark = filter.state().template segment<2>(filter.offset_of(id));
    z.push_back({id, measure_range_bearing(filter.pose(), landmark)});
  }
  return z;
}

double triangle(int landmarks) {
  const double n = 2.0 * landmarks;
  return n * (n + 1.0) / 2.0;
}

template <class Filter>
void run_steps(benchmark::State& state, Filter filter) {
  const int landmarks = static_cast<int>(state.range(0)), observed = static_cast<int>(state.range(1));
  // Twice round, so that any landmark may be the first of a batch.
  Observations z = expected_observations(filter);
  z.insert(z.end(), z.begin(), z.begin() + landmarks);
  int first = 0;
  constexpr int kSteps = 48;
  for (auto _ : state) {
    for (int k = 0; k < kSteps; ++k) {
      filter.predict({0.0, 0.0});
      benchmark::DoNotOptimize(filter.update(
          std::span(z).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(observed))));
      first = (first + observed) % landmarks;
    }
  }
  state.SetItemsProcessed(state.iterations() * kSteps);
  // What the downdate of one triangle by 2 m columns needs; all else is small beside it.
  state.counters["multiply_adds"] = kSteps * 2.0 * observed * triangle(landmarks);
}

/// Arguments: N, landmarks observed at each step.
void full_step(benchmark::State& state) {
  run_steps(state, planar_filter<EkfSlam<PlanarModel>>(static_cast<int>(state.range(0))));
}
BENCHMARK(full_step)->ArgsProduct({{100, 500, 1000}, {1}})->Args({1000, 10});

}  // namespace
}  // namespace credence::internal
