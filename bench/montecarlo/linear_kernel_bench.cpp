// One step of one run of the monobot, noise, NEES and NIS included: the lanes of LinearSimulator beside the
// plain loop that a textbook would give, with the random numbers of the standard library. Items are steps.

#include "montecarlo/lanes/linear_kernel.h"

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "core/filters/linear_filter.h"
#include "core/linear_algebra/psd_root.h"
#include "montecarlo/worlds/monobot/plain_monobot.h"

namespace credence::internal {
namespace {

constexpr Index kSteps = 100;

LinearErrorSystem monobot(Index landmarks) {
  const LinearModel model = monobot_model(landmarks, 0, 0.1, 0.1, 1.0);
  LinearErrorSystem system{{.F = model.F,
                            .noise_input = model.G * psd_root(model.Q),
                            .H = model.H,
                            .measurement_root = psd_root(model.R)},
                           psd_root(model.P0),
                           {},
                           {}};
  for (const LinearFilterStep& step : linear_filter_steps(model, {}, kSteps)) {
    system.steps.push_back({.K = step.K,
                            .innovation_whitening = psd_whitening(step.S),
                            .error_whitening = psd_whitening(step.P)});
  }
  return system;
}

/// The argument is N.
void lanes(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const Index runs = state.range(0) > 20 ? 64 : 512;
  const LinearSimulator simulator(monobot(state.range(0)));
  const NoiseSource noise(1, 0, set);
  std::vector<Moments> nees(kSteps), nis(kSteps);
  Index first_run = 0;
  for (auto _ : state) {
    simulator.simulate(noise, first_run, runs, nees, nis);
    benchmark::DoNotOptimize(nees.data());
    first_run += runs;
  }
  state.SetItemsProcessed(state.iterations() * runs * kSteps);
}
BENCHMARK_CAPTURE(lanes, scalar, InstructionSet::scalar)->Arg(1);
BENCHMARK_CAPTURE(lanes, avx2, InstructionSet::avx2)->Arg(1)->Arg(2)->Arg(5)->Arg(20)->Arg(100);
BENCHMARK_CAPTURE(lanes, avx512, InstructionSet::avx512)->Arg(1)->Arg(2)->Arg(5)->Arg(20)->Arg(100);

/// Only the noise of the same steps: one process noise and N measurements.
void noise_alone(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const Index slots = state.range(0) + 1;
  const NoiseSource noise(1, 0, set);
  constexpr Index kBlock = 20;
  std::vector<double> out(static_cast<std::size_t>(slots * kBlock * NoiseSource::kLanes));
  Index step = 1;
  for (auto _ : state) {
    noise.normals_of_runs(0, step, kBlock, NoisePurpose::measurement, slots, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
    step = (step + kBlock) % (1 << 20);
  }
  state.SetItemsProcessed(state.iterations() * kBlock * NoiseSource::kLanes);
}
BENCHMARK_CAPTURE(noise_alone, avx2, InstructionSet::avx2)->Arg(1)->Arg(2)->Arg(20);
BENCHMARK_CAPTURE(noise_alone, avx512, InstructionSet::avx512)->Arg(1)->Arg(2)->Arg(20);

/// The textbook loop; the argument is N.
void plain_loop(benchmark::State& state) {
  std::mt19937_64 generator(1);
  std::vector<Moments> nees(kSteps), nis(kSteps);
  for (auto _ : state) {
    run_plain_monobot(state.range(0), 1, generator, nees, nis);
    benchmark::DoNotOptimize(nees.data());
    benchmark::DoNotOptimize(nis.data());
  }
  state.SetItemsProcessed(state.iterations() * kSteps);
}
BENCHMARK(plain_loop)->Arg(1)->Arg(2)->Arg(5);

}  // namespace
}  // namespace credence::internal
