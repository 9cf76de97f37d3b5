// One step of one run of a monobot that misses measurements, so that every run does a Riccati step of its
// own; noise, NEES and NIS included. Beside it: plain_loop of linear_kernel_bench.cpp, which does one as
// well, and the run by matrices. Items are steps.

#include <benchmark/benchmark.h>

#include <vector>

#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/linear/intermittent_experiment.h"
#include "montecarlo/worlds/monobot/monobot_world.h"

namespace credence::internal {
namespace {

/// The argument is N.
LinearProblem problem_of(const benchmark::State& state, InflationSolution solution) {
  Scenario scenario = default_scenario("monobot");
  scenario.world.landmarks = state.range(0);
  if (solution != InflationSolution::pairwise) scenario.filter.inflation = FilterInflation::map;
  scenario.filter.solution = solution;
  scenario.noise.detection_probability = 0.9;
  return monobot_problem(scenario);
}

void run_chunks(benchmark::State& state, const IntermittentExperiment& experiment, std::int64_t runs) {
  std::int64_t first = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(experiment.run_chunk(first, runs));
    first += runs;
  }
  state.SetItemsProcessed(state.iterations() * runs * 100);
}

void own_riccati(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  run_chunks(state, {problem_of(state, InflationSolution::pairwise), 100, NoiseSource(1, 0, set)}, 64);
}
BENCHMARK_CAPTURE(own_riccati, scalar, InstructionSet::scalar)->Arg(1);
BENCHMARK_CAPTURE(own_riccati, avx2, InstructionSet::avx2)->Arg(1)->Arg(2)->Arg(5)->Arg(12);
BENCHMARK_CAPTURE(own_riccati, avx512, InstructionSet::avx512)->Arg(1)->Arg(2)->Arg(5)->Arg(12);

/// What no lane does: here because its inflation is the sequential one.
void own_riccati_by_matrices(benchmark::State& state) {
  run_chunks(state, {problem_of(state, InflationSolution::sequential), 100, NoiseSource(1, 0)}, 8);
}
BENCHMARK(own_riccati_by_matrices)->Arg(1)->Arg(5);

/// Of the same steps the random numbers alone.
void noise_and_events_alone(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const Index measurements = state.range(0);
  const NoiseSource noise(1, 0, set);
  constexpr Index kBlock = 16;
  const auto size = static_cast<std::size_t>(kBlock * NoiseSource::kLanes);
  std::vector<double> process(size), out(static_cast<std::size_t>(measurements) * size), seen(out.size());
  Index step = 1;
  for (auto _ : state) {
    noise.normals_of_runs(0, step, kBlock, NoisePurpose::process, 1, process);
    noise.normals_of_runs(0, step, kBlock, NoisePurpose::measurement, measurements, out);
    noise.events_of_runs(0, step, kBlock, NoisePurpose::detection, 0.9, measurements, seen);
    benchmark::ClobberMemory();
    step = (step + kBlock) % (1 << 20);
  }
  state.SetItemsProcessed(state.iterations() * kBlock * NoiseSource::kLanes);
}
BENCHMARK_CAPTURE(noise_and_events_alone, avx2, InstructionSet::avx2)->Arg(1);
BENCHMARK_CAPTURE(noise_and_events_alone, avx512, InstructionSet::avx512)->Arg(1);

}  // namespace
}  // namespace credence::internal
