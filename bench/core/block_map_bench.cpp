// One step of the O(N) filter, and of the dense filter with the same inflation beside it.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/filters/block_map_ekf_slam.h"
#include "core/filters/ekf_slam.h"

namespace credence::internal {
namespace {

using Filter = BlockMapEkfSlam<PlanarModel>;

enum class Case {
  kept,   ///< one landmark dominates: a part of its information is kept, and every block changes
  whole,  ///< the map is correlated with the vehicle: no landmark dominates
  batch,  ///< the same, by the bound of the batch
  drop,
};

/// A map on rings around the vehicle, each landmark correlated with it by `correlation`.
Vector map_state(int landmarks) {
  Vector x = Vector::Zero(3 + 2 * landmarks);
  for (int j = 0; j < landmarks; ++j) {
    const double angle = 2.399963 * j, range = 10.0 + 0.001 * j;
    x.segment<2>(3 + 2 * j) = range * Point(std::cos(angle), std::sin(angle));
  }
  return x;
}

ArrowCovariance map_covariance(int landmarks, double correlation) {
  ArrowCovariance P(3, 2);
  P.set_vehicle(Matrix(Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal()));
  P.reserve(landmarks);
  for (int j = 0; j < landmarks; ++j) {
    ArrowCovariance::CrossMatrix rf(3, 2);
    rf << 0.01, 0.001 * std::sin(j), 0.001 * std::cos(j), 0.01, 0.0005, 0.001;
    P.append(correlation * rf, Eigen::Matrix2d(0.2 * Eigen::Matrix2d::Identity()));
  }
  return P;
}

std::vector<int> first_numbers(int count) {
  std::vector<int> ids(static_cast<std::size_t>(count));
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

/// What `filter` sees of m landmarks, each measured for ten steps before the next.
template <class F>
std::vector<Observation<PlanarModel>> observe(const F& filter, const Vector& map, int landmarks, int m,
                                              int k) {
  std::vector<Observation<PlanarModel>> seen;
  for (int i = 0; i < m; ++i) {
    const int id = (k / 10 * m + i) % landmarks;
    seen.push_back({id, measure_range_bearing(filter.pose(), map.segment<2>(3 + 2 * id))});
  }
  return seen;
}

const Eigen::Matrix2d kQ = Eigen::Vector2d(1e-4, 1e-4).asDiagonal();
const Eigen::Matrix2d kR = Eigen::Vector2d(0.01, 0.0003).asDiagonal();

/// The arguments are N and m; the vehicle stands still, so that a step is the same for ever.
void block_map_step(benchmark::State& state, Case which) {
  const auto N = static_cast<int>(state.range(0)), m = static_cast<int>(state.range(1));
  // A map of which the vehicle knows nothing is the case in which every landmark that is seen dominates.
  const double correlation = which == Case::kept ? 1e-2 / N : 1.0 / std::sqrt(static_cast<double>(N));
  const MapBound bound = which == Case::drop    ? MapBound::drop
                         : which == Case::batch ? MapBound::batch
                                                : MapBound::least_trace;
  Filter filter({.vehicle = {}, .dt_s = 0.1}, kQ, kR, bound);
  const Vector map = map_state(N);
  const std::vector<int> ids = first_numbers(N);
  const ArrowCovariance P = map_covariance(N, correlation);
  filter.reset(map, P, ids);
  int k = 0;
  for (auto _ : state) {
    if (k % 1000 == 0) {
      state.PauseTiming();
      filter.reset(map, P, ids);
      state.ResumeTiming();
    }
    filter.predict({0.0, 0.0});
    const auto seen = observe(filter, map, N, m, k++);
    UpdateResult result = filter.update(seen);
    benchmark::DoNotOptimize(result);
  }
  state.SetComplexityN(N);
  state.counters["ns_per_landmark"] = benchmark::Counter(
      1e-9 * N, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes_per_landmark"] = static_cast<double>(filter.bytes()) / N;
}

BENCHMARK_CAPTURE(block_map_step, sequential, Case::whole)->ArgsProduct({{1000, 10000, 100000}, {1, 10}});
BENCHMARK_CAPTURE(block_map_step, sequential_kept, Case::kept)->ArgsProduct({{1000, 10000, 100000}, {1, 10}});
BENCHMARK_CAPTURE(block_map_step, batch, Case::batch)->ArgsProduct({{1000, 10000, 100000}, {1, 10}});
BENCHMARK_CAPTURE(block_map_step, drop, Case::drop)->ArgsProduct({{1000, 10000, 100000}, {1, 10}});

/// The world of scenarios/map_solutions.toml: six landmarks, of which two or three are in view of a circle of
/// 63 m; the argument is how many such circles stand side by side, the landmarks of all but one never seen
/// again.
void circle_step(benchmark::State& state, MapBound bound) {
  const auto N = static_cast<int>(6 * state.range(0));
  Filter filter({.vehicle = {}, .dt_s = 1.0}, Eigen::Vector2d(0.01, 0.0004).asDiagonal(), kR, bound);
  Vector map = map_state(N);
  Pose truth(10.0, 0.0, 0.5 * std::numbers::pi);
  map.head<3>() = truth;
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * (2 * i + 1) / 6.0, radius = i % 2 == 0 ? 7.0 : 13.0;
    map.segment<2>(3 + 2 * i) = radius * Point(std::cos(angle), std::sin(angle));
  }
  filter.reset(map, map_covariance(N, 0.1 / std::sqrt(static_cast<double>(N))), first_numbers(N));
  std::vector<Observation<PlanarModel>> seen;
  for (auto _ : state) {
    truth = Vehicle{}.moved(truth, Control(1.0, 0.1), 1.0);
    seen.clear();
    for (int i = 0; i < 6; ++i) {
      const RangeBearing z = measure_range_bearing(truth, map.segment<2>(3 + 2 * i));
      if (z[0] <= 12.0) seen.push_back({i, z});
    }
    filter.predict(Control(1.0, 0.1));
    UpdateResult result = filter.update(seen);
    benchmark::DoNotOptimize(result);
  }
}
BENCHMARK_CAPTURE(circle_step, sequential, MapBound::least_trace)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(circle_step, batch, MapBound::batch)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(circle_step, drop, MapBound::drop)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);

/// The dense filter with the same inflation.
void dense_step(benchmark::State& state) {
  const auto N = static_cast<int>(state.range(0)), m = static_cast<int>(state.range(1));
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = InflationSolution::sequential;
  EkfSlam<PlanarModel> filter({.vehicle = {}, .dt_s = 0.1}, kQ, kR, rule);
  const Vector map = map_state(N);
  filter.reset(map, map_covariance(N, 1.0 / std::sqrt(static_cast<double>(N))).dense(), first_numbers(N));
  int k = 0;
  for (auto _ : state) {
    filter.predict({0.0, 0.0});
    const auto seen = observe(filter, map, N, m, k++);
    UpdateResult result = filter.update(seen);
    benchmark::DoNotOptimize(result);
  }
}
BENCHMARK(dense_step)->Args({100, 1})->Args({1000, 1});

}  // namespace
}  // namespace credence::internal
