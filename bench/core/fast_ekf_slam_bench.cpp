// One step (predict and update) of EKF-SLAM in large maps, beside the two limits of the machine: the time to
// stream one triangle of P in place, and the rate of multiply-adds.

#include "core/fast_ekf_slam.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/aligned_vector.h"

namespace credence {
namespace {

using Observations = std::vector<Observation<PlanarModel>>;

/// Starts a filter with all landmarks on rings around it in its map, all of them correlated.
template <class Filter>
Filter planar_filter(int landmarks, auto options) {
  const Eigen::Matrix2d Q = Eigen::Vector2d(0.01, 0.0025).asDiagonal();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
  Filter filter({.vehicle = {}, .dt_s = 0.1}, Q, R, options);
  filter.reset(Pose::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  Observations all;
  for (int i = 0; i < landmarks; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / landmarks;
    all.push_back({i, RangeBearing(10.0 + i % 7, wrap_angle(angle))});
  }
  filter.update(all);
  return filter;
}

/// One predict and one update with the landmarks first … first + count − 1.
template <class Filter>
void step(Filter& filter, int first, int count, Observations& z) {
  const int landmarks = static_cast<int>(filter.layout().landmarks);
  filter.predict({0.0, 0.0});
  z.clear();
  for (int i = 0; i < count; ++i) {
    const int id = (first + i) % landmarks;
    const Index offset = filter.offset_of(id);
    z.push_back({id, measure_range_bearing(filter.pose(), filter.state().template segment<2>(offset))});
  }
  benchmark::DoNotOptimize(filter.update(z));
}

double triangle(int landmarks) {
  const double n = 2.0 * landmarks;
  return n * (n + 1.0) / 2.0;
}

template <class Filter>
void run_steps(benchmark::State& state, Filter filter) {
  const int landmarks = static_cast<int>(state.range(0)), observed = static_cast<int>(state.range(1));
  Observations z;
  int first = 0;
  // A multiple of every number of steps between flushes: each iteration does the same work.
  constexpr int kSteps = 16;
  for (auto _ : state) {
    for (int k = 0; k < kSteps; ++k, first += observed) step(filter, first % landmarks, observed, z);
  }
  state.SetItemsProcessed(state.iterations() * kSteps);
  const double steps = static_cast<double>(state.iterations() * kSteps);
  state.counters["s/step"] =
      benchmark::Counter(steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["fma/s"] =
      benchmark::Counter(2.0 * observed * triangle(landmarks) * steps, benchmark::Counter::kIsRate);
}

/// Arguments: N, landmarks observed at each step, steps between flushes.
void fast_step(benchmark::State& state) {
  const FastEkfSlamOptions options{.flush_steps = static_cast<int>(state.range(2))};
  run_steps(state, planar_filter<FastEkfSlam<PlanarModel>>(static_cast<int>(state.range(0)), options));
}
BENCHMARK(fast_step)->ArgsProduct({{100, 500, 1000}, {1}, {1, 4, 8, 16}});
BENCHMARK(fast_step)->ArgsProduct({{1000}, {10}, {1, 4}});

/// The plain filter on dense matrices; arguments N and landmarks observed at each step.
void plain_step(benchmark::State& state) {
  run_steps(state, planar_filter<EkfSlam<PlanarModel>>(static_cast<int>(state.range(0)), InflationRule{}));
}
BENCHMARK(plain_step)->Args({100, 1})->Args({500, 1})->Args({1000, 1})->Args({1000, 10})->Iterations(1);

/// Reads and writes every element of a triangle of the map covariance of N landmarks once.
void stream_triangle(benchmark::State& state) {
  AlignedVector triangle_of_P(static_cast<std::size_t>(triangle(static_cast<int>(state.range(0)))), 1.0);
  for (auto _ : state) {
    for (double& x : triangle_of_P) x *= 0.9999;
    benchmark::ClobberMemory();
  }
}
BENCHMARK(stream_triangle)->Arg(100)->Arg(500)->Arg(1000);

}  // namespace
}  // namespace credence
