#include <benchmark/benchmark.h>

#include <random>

#include "core/inflation/inflation.h"
#include "core/inflation/min_trace.h"
#include "core/inflation/rank_one_bound.h"

namespace credence::internal {
namespace {

Matrix random_covariance(Index n, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  Matrix root(n, n);
  for (double& entry : root.reshaped()) entry = normal(bits);
  return root * root.transpose();
}

BlockLayout planar(Index landmarks) { return {.vehicle = 3, .landmark = 2, .landmarks = landmarks}; }
BlockLayout monobot(Index landmarks) { return {.vehicle = 1, .landmark = 1, .landmarks = landmarks}; }

/// The floor of the dense benchmarks: each of them starts from a fresh copy of P.
void copy_of_p(benchmark::State& state) {
  const Matrix P = random_covariance(planar(state.range(0)).state_dim(), 1);
  Matrix D = P;
  for (auto _ : state) {
    D = P;
    benchmark::DoNotOptimize(D.data());
    benchmark::ClobberMemory();
  }
}

void pairwise(benchmark::State& state, const BlockLayout& layout, Inflation inflation) {
  const Matrix P = random_covariance(layout.state_dim(), 1);
  Matrix D = P;
  for (auto _ : state) {
    D = P;
    inflate(D, layout, inflation, InflationSolution::pairwise);
    benchmark::DoNotOptimize(D.data());
    benchmark::ClobberMemory();
  }
  const Index pairs =
      layout.landmarks * (layout.landmarks - 1) / 2 + (inflation == Inflation::full ? layout.landmarks : 0);
  state.SetItemsProcessed(state.iterations() * pairs);
  state.SetComplexityN(layout.landmarks);
}
void pairwise_planar_full(benchmark::State& state) {
  pairwise(state, planar(state.range(0)), Inflation::full);
}
void pairwise_planar_map(benchmark::State& state) { pairwise(state, planar(state.range(0)), Inflation::map); }
void pairwise_monobot_full(benchmark::State& state) {
  pairwise(state, monobot(state.range(0)), Inflation::full);
}

void report(benchmark::State& state, const MinTraceBound& last, const BlockLayout& layout) {
  state.counters["gap"] = last.relative_gap;
  state.counters["sweeps"] = static_cast<double>(last.sweeps);
  state.counters["interior_point_steps"] = static_cast<double>(last.interior_point_steps);
  state.SetComplexityN(layout.landmarks);
}

/// From nothing, on a random covariance: harder than what a filter meets.
void min_trace_cold(benchmark::State& state) {
  const BlockLayout layout = planar(state.range(0));
  const Matrix P = random_covariance(layout.state_dim(), 1);
  MinTraceBound bound;
  for (auto _ : state) bound = min_trace_bound(P, layout);
  report(state, bound, layout);
}

/// Along a run: P moves by 1 % from step to step, the dual factors are kept.
void min_trace_warm(benchmark::State& state) {
  const BlockLayout layout = planar(state.range(0));
  const Index n = layout.state_dim();
  const Matrix P = random_covariance(n, 1), Q = random_covariance(n, 2);
  Matrix steps[2] = {P, 0.99 * P + 0.01 * Q};
  MinTraceState factors;
  MinTraceBound bound = min_trace_bound(P, layout, {}, &factors);
  int step = 0;
  for (auto _ : state) bound = min_trace_bound(steps[++step % 2], layout, {}, &factors);
  report(state, bound, layout);
}

/// The O(N) inflation of one scalar measurement: weights, then all diagonal blocks of the map.
void rank_one(benchmark::State& state, Index d) {
  const Index n_f = d * state.range(0);
  std::mt19937_64 bits(3);
  std::normal_distribution<double> normal(0.0, 1e-3);
  Vector l(n_f);
  for (double& entry : l) entry = normal(bits);
  l.head(d).setConstant(10.0 * static_cast<double>(state.range(0)));  // one landmark outweighs all others
  Matrix blocks = Matrix::Zero(d, n_f);
  for (auto _ : state) {
    reduce_and_inflate(rank_one_bound(l, d), l, d, blocks);
    benchmark::DoNotOptimize(blocks.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetComplexityN(state.range(0));
}
void rank_one_scalars(benchmark::State& state) { rank_one(state, 1); }
void rank_one_planar(benchmark::State& state) { rank_one(state, 2); }

BENCHMARK(copy_of_p)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(pairwise_planar_full)->Arg(10)->Arg(100)->Arg(1000)->Complexity(benchmark::oNSquared);
BENCHMARK(pairwise_planar_map)->Arg(10)->Arg(100)->Arg(1000)->Complexity(benchmark::oNSquared);
BENCHMARK(pairwise_monobot_full)
    ->Arg(1)
    ->Arg(2)
    ->Arg(10)
    ->Arg(100)
    ->Arg(1000)
    ->Complexity(benchmark::oNSquared);
BENCHMARK(min_trace_cold)->Arg(2)->Arg(10)->Arg(30)->Arg(100)->Unit(benchmark::kMicrosecond);
BENCHMARK(min_trace_warm)->Arg(2)->Arg(10)->Arg(30)->Arg(100)->Unit(benchmark::kMicrosecond);
BENCHMARK(rank_one_scalars)->RangeMultiplier(10)->Range(10, 100000)->Complexity(benchmark::oN);
BENCHMARK(rank_one_planar)->RangeMultiplier(10)->Range(10, 100000)->Complexity(benchmark::oN);

}  // namespace
}  // namespace credence::internal
