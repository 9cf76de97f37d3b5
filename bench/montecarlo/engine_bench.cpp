// Runs per second of the engine, noise and statistics included; the argument is the number of threads.

#include "montecarlo/engine.h"

#include <benchmark/benchmark.h>

namespace credence {
namespace {

void run_engine(benchmark::State& state, const Scenario& scenario) {
  const auto experiment = make_experiment(scenario);
  const StudyTask task{"", experiment.get(), scenario.study.runs};
  EngineOptions options;
  options.threads = static_cast<int>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(run_studies({&task, 1}, options));
  state.SetItemsProcessed(state.iterations() * scenario.study.runs);
}

void monobot_runs(benchmark::State& state) {
  Scenario scenario = default_scenario(WorldModel::monobot);
  scenario.study.runs = 10'000;
  run_engine(state, scenario);
}
BENCHMARK(monobot_runs)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

void planar_runs(benchmark::State& state) {
  Scenario scenario = default_scenario(WorldModel::planar);
  scenario.world.landmarks = 10;
  scenario.study.runs = 512;
  run_engine(state, scenario);
}
BENCHMARK(planar_runs)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace credence
