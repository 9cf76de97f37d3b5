#include "datasets/replay/replay_log.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

RunLayout layout_of(const ReplayResult& replay) {
  RunLayout layout;
  if (has_true_heading(replay)) {
    layout.states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
    layout.angles = {false, false, true};
    add_named_blocks(layout);
  } else {
    layout.states = {"x", "y"};
    layout.angles = {false, false};
    layout.units = {"m", "m"};
    layout.blocks = {{"position", Part::position, {0, 1}}};
  }
  const ReplayNoise& noise = replay.settings.noise;
  const double bearing_std = noise.bearing_std_deg * kRadiansPerDegree;
  layout.sensors = {{.name = "",
                     .dim = 2,
                     .piece = 2,
                     .variances = {noise.range_std * noise.range_std, bearing_std * bearing_std},
                     .angles = {false, true}}};
  layout.has_truth = !replay.references.empty();
  const ReplayFilterSettings& filter = replay.settings.filter;
  layout.nonlinear = filter.jacobians == ReplayJacobians::estimate && filter.estimator != "ideal";
  layout.inflated = filter.inflation != Inflation::none;
  return layout;
}

void compare(const ReplayReference& reference, const ReplaySettings& settings, Step& step) {
  const Index n = reference.dof;
  step.states.resize(static_cast<std::size_t>(n));
  std::iota(step.states.begin(), step.states.end(), 0);
  step.estimate = reference.estimate.head(n);
  step.error = step.estimate - reference.truth.head(n);
  const double position = settings.truth.position_std;
  const double heading = settings.truth.heading_std_deg * kRadiansPerDegree;
  const Eigen::Vector3d variances(position * position, position * position, heading * heading);
  step.P = reference.covariance.topLeftCorner(n, n);
  step.P.diagonal() += variances.head(n);
  if (n == 3) step.error[2] = wrap_angle(step.error[2]);
}

Innovation innovation_of(const ReplayObservation& observation, bool alone) {
  if (alone) return {observation.innovation, observation.S};
  return {observation.root * observation.whitened, observation.root * observation.root.transpose()};
}

/// Ends a row where the next one begins.
class Rows {
 public:
  explicit Rows(LogSink& sink) : sink_(sink) { clear(); }

  void add(double time_s, Innovation innovation) {
    if (open_) end();
    row_.innovations = {std::move(innovation)};
    time_s_ = time_s;
    open_ = true;
  }
  void add(const ReplayReference& reference, const ReplaySettings& settings) {
    compare(reference, settings, row_);
    time_s_ = reference.time_s;
    end();
  }
  void end() {
    row_.step = ++rows_;
    sink_.at(time_s_);
    sink_.add(row_);
    clear();
  }
  bool open() const { return open_; }

 private:
  void clear() {
    row_ = {};
    row_.innovations.resize(1);
    open_ = false;
  }

  LogSink& sink_;
  Step row_;
  double time_s_ = 0.0;
  std::int64_t rows_ = 0;
  bool open_ = false;  ///< the row has an innovation
};

}  // namespace

void read_replay(const ReplayResult& replay, LogSink& sink) {
  const bool gated = std::isfinite(gate_of(replay));
  sink.begin_run(layout_of(replay));
  Rows rows(sink);
  auto reference = replay.references.begin();
  for (const ReplayObservation& observation : replay.records) {
    if (observation.outcome != ObservationOutcome::updated) continue;
    if (gated && !observation.first_of_batch) continue;
    for (; reference != replay.references.end() && reference->time_s < observation.time_s; ++reference)
      rows.add(*reference, replay.settings);
    rows.add(observation.time_s, innovation_of(observation, gated));
  }
  for (; reference != replay.references.end(); ++reference) rows.add(*reference, replay.settings);
  if (rows.open()) rows.end();
}

double gate_of(const ReplayResult& replay) {
  const double probability = replay.settings.filter.gate;
  return probability > 0.0 ? gate_threshold(probability) : std::numeric_limits<double>::infinity();
}

}  // namespace credence::internal
