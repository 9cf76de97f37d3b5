#include "analysis/stability/planar_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/memory_need.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/path_length.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {
namespace {

using Seen = std::span<const Observation<PlanarModel>>;

/// H of what is known of `seen`, at the filter's estimate, in the filter's own order.
template <PlanarSlamFilter F>
Matrix measurement_jacobian(const F& filter, const PlanarWorld& world, Seen seen) {
  const Vector& x = filter.state();
  Matrix H = Matrix::Zero(2 * static_cast<Index>(seen.size()), x.size());
  Index rows = 0;
  for (const Observation<PlanarModel>& o : seen) {
    const bool anchored = o.landmark >= world.states();
    const Index offset = anchored ? -1 : filter.offset_of(o.landmark);
    if (!anchored && offset < 0) continue;
    const Point landmark =
        anchored ? world.landmarks[static_cast<std::size_t>(o.landmark)] : Point(x.segment<2>(offset));
    const PredictedRangeBearing predicted = predict_range_bearing(filter.pose(), landmark);
    H.block<2, 3>(rows, 0) = predicted.H_r;
    if (!anchored) H.block<2, 2>(rows, offset) = predicted.H_l;
    rows += 2;
  }
  H.conservativeResize(rows, Eigen::NoChange);
  return H;
}

/// Writes one loop down while it is driven.
class Recorder {
 public:
  Recorder(const Scenario& scenario, const PlanarWorld& world, PlanarLoopRecord& loop)
      : world_(world), loop_(loop), Q_(AssumedPlanarNoise::of(scenario).Q) {}

  template <PlanarSlamFilter F>
  void begin(F& filter) {
    if constexpr (requires { filter.keep_gain(true); }) filter.keep_gain(true);
    loop_.layout = filter.layout();
    loop_.start = filter.state();
    loop_.H.emplace_back(0, filter.state().size());
  }

  template <PlanarSlamFilter F>
  void before_predict(const F& filter, const Control& u) {
    const Index n = filter.state().size();
    const Motion motion = world_.vehicle.move(filter.pose(), u, world_.dt_s);
    loop_.F.push_back(Matrix::Identity(n, n));
    loop_.F.back().topLeftCorner<3, 3>() = motion.F;
    loop_.process.push_back(Matrix::Zero(n, n));
    loop_.process.back().topLeftCorner<3, 3>() = motion.G * Q_ * motion.G.transpose();
  }

  template <PlanarSlamFilter F>
  void before_update(const F& filter, Seen seen) {
    loop_.H.push_back(measurement_jacobian(filter, world_, seen));
    const Index n = filter.state().size();
    loop_.inflation.push_back(Matrix::Zero(n, n));
    if constexpr (requires { filter.inflated_prior(); }) {
      loop_.inflation.back() = filter.inflated_prior() - filter.covariance();
    }
  }

  template <PlanarSlamFilter F>
  void after_update(const F& filter) {
    const bool none = loop_.H.back().rows() == 0;
    loop_.K.push_back(none ? Matrix(filter.state().size(), 0) : Matrix(filter.gain()));
  }

 private:
  const PlanarWorld& world_;
  PlanarLoopRecord& loop_;
  Eigen::Matrix2d Q_;
};

template <PlanarSlamFilter F>
PlanarPathRun follow(F filter, PlanarWorld world, const Scenario& longer, Index per_loop, Linearisation at) {
  const Index steps = longer.study.steps, before_last = steps - per_loop;
  PlanarPathRun run;
  run.world = std::move(world);
  const PlanarNoise noise = PlanarNoise::of(longer);
  std::optional<NoiseSource> source;
  if (at == Linearisation::estimate) source.emplace(noise_source(longer));
  PlanarSimulation simulation(run.world, noise, source);
  filter.reset(simulation.start(0), noise.initial_covariance());
  Recorder recorder(longer, run.world, run.loop);
  StateError error;
  double nees = 0.0, trace = 0.0;
  const Index second_half = steps / 2;
  for (Index k = 1; k <= steps; ++k) {
    stop_point();
    const Control& u = run.world.controls[static_cast<std::size_t>(k - 1)];
    const bool all_known = static_cast<Index>(filter.landmarks().size()) == run.world.states();
    if (k == before_last + 1 && all_known) {
      constexpr double kMatrices = 3.0;  // F, GQGᵀ and ΔP; H and K have fewer elements
      const auto n = static_cast<double>(filter.state().size());
      require_memory(static_cast<double>(per_loop) * kMatrices * n * n * sizeof(double),
                     fmt::format("{} states over a loop of {} steps", n, per_loop));
      recorder.begin(filter);
    }
    const bool recording = k > before_last && !run.loop.H.empty();
    simulation.move(static_cast<std::size_t>(k));
    const Seen seen = simulation.observe(static_cast<std::size_t>(k));
    if (recording) recorder.before_predict(filter, u);
    filter.predict(u);
    if (recording) recorder.before_update(filter, seen);
    const UpdateResult update = filter.update(seen);
    run.ok = update.ok && filter.state().allFinite() &&
             error.compute(simulation.pose(), run.world.landmarks, filter.state(), filter.covariance(),
                           filter.landmarks()) == Outcome::ok;
    if (!run.ok) {
      run.failed_at = k;
      run.loop = {};
      break;
    }
    if (recording) recorder.after_update(filter);
    run.not_converged += update.converged ? 0 : 1;
    if (k > second_half) nees += error.vehicle_nees / 3.0;
    trace += planar_traces(filter.covariance()).all;
    if (k % per_loop == 0) {
      run.traces.push_back(trace / static_cast<double>(per_loop));
      trace = 0.0;
    }
  }
  const bool judged = run.ok && at == Linearisation::estimate;
  run.pose_nees = judged ? nees / static_cast<double>(steps - second_half) : kNaN;
  return run;
}

}  // namespace

Index planar_steps_per_loop(const Scenario& scenario) {
  constexpr double kMost = 1e7;
  const WorldSettings& w = scenario.world;
  const double exact = loop_length_m(w.path, w.path_radius) / (w.speed * w.dt);
  const double steps = std::max(0.0, std::ceil(exact - 1e-9));
  if (steps >= 1.0 && steps <= kMost) return static_cast<Index>(steps);
  throw std::invalid_argument(
      fmt::format("world.path_radius = {}, world.speed = {}, world.dt = {}: once round the path takes {:.3g} "
                  "steps; accepted are 1 to {}",
                  w.path_radius, w.speed, w.dt, steps, kMost));
}

PlanarPathRun follow_planar_path(const Scenario& scenario, Index loops, Linearisation at) {
  const Index per_loop = planar_steps_per_loop(scenario);
  Scenario longer = scenario;
  longer.study.steps = loops * per_loop;
  require_memory(static_cast<double>(longer.study.steps) * sizeof(Control),
                 fmt::format("{} loops of {} steps", loops, per_loop));
  PlanarWorld world = make_planar_world(longer);
  if (has_block_map(longer)) {
    BlockMapEkfSlam<PlanarModel> filter = make_block_map_filter(longer, world);
    return follow(std::move(filter), std::move(world), longer, per_loop, at);
  }
  EkfSlam<PlanarModel> filter = make_planar_filter(longer, world);
  return follow(std::move(filter), std::move(world), longer, per_loop, at);
}

}  // namespace credence::internal
