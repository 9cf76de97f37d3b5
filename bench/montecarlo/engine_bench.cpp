// Runs per second of the engine, noise and statistics included; the argument is the number of threads.

#include "montecarlo/engine/engine.h"

#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
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
  Scenario scenario = default_scenario("monobot");
  scenario.study.runs = 10'000;
  run_engine(state, scenario);
}
BENCHMARK(monobot_runs)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

Scenario planar_scenario() {
  Scenario scenario = default_scenario("planar");
  scenario.world.landmarks = 10;
  scenario.study.runs = 2048;
  return scenario;
}

void planar_runs(benchmark::State& state) { run_engine(state, planar_scenario()); }
BENCHMARK(planar_runs)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

/// The same with one EkfSlam after the other, as it is done for the filters that inflate.
void planar_runs_by_matrices(benchmark::State& state) {
  const Scenario scenario = planar_scenario();
  PlanarWorld world = make_planar_world(scenario);
  auto make_filter = [filter = make_planar_filter(scenario, world)] { return filter; };
  const PlanarExperiment<EkfSlam<PlanarModel>> experiment(std::move(world), PlanarNoise::of(scenario),
                                                          NoiseSource(1, noise_group(scenario)), make_filter);
  for (auto _ : state) benchmark::DoNotOptimize(experiment.run_chunk(0, kChunkRuns));
  state.SetItemsProcessed(state.iterations() * kChunkRuns);
}
BENCHMARK(planar_runs_by_matrices)->Unit(benchmark::kMillisecond);

/// What the world of eight runs does and shows, written down.
class RecordedBatch {
 public:
  explicit RecordedBatch(const Scenario& scenario)
      : noise_(PlanarNoise::of(scenario)), world_(make_planar_world(scenario)) {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      PlanarSimulation simulation(world_, noise_, NoiseSource(1, noise_group(scenario)));
      starts_.push_back(simulation.start(lane));
      for (std::size_t k = 1; k <= steps(); ++k) {
        simulation.move(k);
        const auto z = simulation.observe(k);
        seen_.emplace_back(z.begin(), z.end());
      }
    }
  }

  std::size_t steps() const { return world_.controls.size(); }
  const PlanarWorld& world() const { return world_; }

  void filter(PlanarLanes& lanes) const {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      lanes.reset(lane, starts_[static_cast<std::size_t>(lane)], noise_.initial_covariance());
    }
    for (std::size_t k = 0; k < steps(); ++k) {
      std::array<PlanarLanes::Observations, PlanarLanes::kLanes> seen;
      for (std::size_t lane = 0; lane < seen.size(); ++lane) seen[lane] = seen_[lane * steps() + k];
      lanes.predict(world_.controls[k]);
      lanes.update(seen);
    }
  }

 private:
  PlanarNoise noise_;
  PlanarWorld world_;
  std::vector<Pose> starts_;
  std::vector<std::vector<Observation<PlanarModel>>> seen_;
};

/// Of the same runs the filter alone, without world, noise, errors and statistics.
void planar_filter_alone(benchmark::State& state) {
  const Scenario scenario = planar_scenario();
  const RecordedBatch batch(scenario);
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
  PlanarLanes lanes(batch.world(), assumed.Q, assumed.measurement_variance);
  for (auto _ : state) {
    batch.filter(lanes);
    benchmark::DoNotOptimize(lanes.step(0));
  }
  state.SetItemsProcessed(state.iterations() * PlanarLanes::kLanes);
}
BENCHMARK(planar_filter_alone);

/// The same runs without statistics: world, noise and filter.
void planar_runs_without_statistics(benchmark::State& state) {
  const Scenario scenario = planar_scenario();
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(scenario);
  std::vector<PlanarSimulation> simulations(
      PlanarLanes::kLanes, PlanarSimulation(world, noise, NoiseSource(1, noise_group(scenario))));
  PlanarLanes lanes(world, assumed.Q, assumed.measurement_variance);
  std::int64_t run = 0;
  for (auto _ : state) {
    for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
      lanes.reset(lane, simulations[static_cast<std::size_t>(lane)].start(run++), noise.initial_covariance());
    }
    for (std::size_t k = 1; k <= world.controls.size(); ++k) {
      std::array<PlanarLanes::Observations, PlanarLanes::kLanes> seen;
      for (std::size_t lane = 0; lane < seen.size(); ++lane) {
        simulations[lane].move(k);
        seen[lane] = simulations[lane].observe(k);
      }
      lanes.predict(world.controls[k - 1]);
      lanes.update(seen);
    }
    benchmark::DoNotOptimize(lanes.step(0));
  }
  state.SetItemsProcessed(state.iterations() * PlanarLanes::kLanes);
}
BENCHMARK(planar_runs_without_statistics)->UseRealTime();

/// Of the same runs the world alone: where the vehicle drives and what it sees, noise included.
void planar_world_alone(benchmark::State& state) {
  const Scenario scenario = planar_scenario();
  const PlanarWorld world = make_planar_world(scenario);
  PlanarSimulation simulation(world, PlanarNoise::of(scenario), NoiseSource(1, noise_group(scenario)));
  std::int64_t run = 0;
  for (auto _ : state) {
    simulation.start(run++);
    for (std::size_t k = 1; k <= world.controls.size(); ++k) {
      simulation.move(k);
      benchmark::DoNotOptimize(simulation.observe(k).data());
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(planar_world_alone);

}  // namespace
}  // namespace credence::internal
