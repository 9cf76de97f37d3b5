// Standard normals: the project's at every instruction set, beside the standard library's.

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "montecarlo/random/noise.h"

namespace credence::internal {
namespace {

constexpr std::size_t kCount = 2048;  // stays in the L1 cache

void normals_of_the_standard_library(benchmark::State& state) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  std::vector<double> x(kCount);
  for (auto _ : state) {
    for (double& value : x) value = normal(generator);
    benchmark::DoNotOptimize(x.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kCount));
}
BENCHMARK(normals_of_the_standard_library);

/// Two slots and 32 steps for 32 runs at once: what the linear kernel does with N = 1.
void normals_of_runs(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const NoiseSource source(1, 0, set);
  std::vector<double> x(kCount);
  std::int64_t step = 1;
  for (auto _ : state) {
    source.normals_of_runs(0, step, 32, NoisePurpose::process, 2, x);
    benchmark::DoNotOptimize(x.data());
    benchmark::ClobberMemory();
    step = (step + 32) % (1 << 20);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kCount));
}
BENCHMARK_CAPTURE(normals_of_runs, scalar, InstructionSet::scalar);
BENCHMARK_CAPTURE(normals_of_runs, avx2, InstructionSet::avx2);
BENCHMARK_CAPTURE(normals_of_runs, avx512, InstructionSet::avx512);

/// The slots of one step of one run; the argument is their number. One of the four normals of a block is
/// used.
void normals_of_slots(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const NoiseSource source(1, 0, set);
  std::vector<double> x(static_cast<std::size_t>(state.range(0)));
  std::int64_t step = 0;
  for (auto _ : state) {
    source.normals(0, step, NoisePurpose::measurement, x);
    benchmark::DoNotOptimize(x.data());
    benchmark::ClobberMemory();
    step = (step + 1) % (1 << 20);
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK_CAPTURE(normals_of_slots, scalar, InstructionSet::scalar)->Arg(2)->Arg(20);
BENCHMARK_CAPTURE(normals_of_slots, avx2, InstructionSet::avx2)->Arg(2)->Arg(20)->Arg(1000);
BENCHMARK_CAPTURE(normals_of_slots, avx512, InstructionSet::avx512)->Arg(2)->Arg(20)->Arg(1000);

}  // namespace
}  // namespace credence::internal
