// One step of the O(N) filter, and of the dense filter with the same inflation beside it.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/filters/block_map_ekf_slam.h"

namespace credence {
namespace {

using Filter = BlockMapEkfSlam<PlanarModel>;

enum class Case {
  kept,   ///< one landmark dominates: a part of its information is kept, and every block changes
  whole,  ///< the map is correlated with the vehicle: no landmark dominates
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
  Filter filter({.vehicle = {}, .dt_s = 0.1}, kQ, kR,
                which == Case::drop ? MapBound::drop : MapBound::least_trace);
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
BENCHMARK_CAPTURE(block_map_step, drop, Case::drop)->ArgsProduct({{1000, 10000, 100000}, {1, 10}});

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
}  // namespace credence
