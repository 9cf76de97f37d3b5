#include "analysis/planar_path.h"

#include <cmath>

#include "core/angle.h"
#include "core/nan.h"
#include "montecarlo/filter_setup.h"
#include "montecarlo/path_length.h"
#include "montecarlo/planar_experiment.h"
#include "montecarlo/scenario_text.h"

namespace credence {
namespace {

using PlanarFilter = EkfSlam<PlanarModel>;

/// The true vehicle and what its sensor says, with or without noise.
class Drive {
 public:
  Drive(const PlanarWorld& world, const Scenario& scenario, bool noisy)
      : world_(world),
        noise_(PlanarNoise::of(scenario)),
        source_(scenario.study.seed, noise_group(scenario)),
        noisy_(noisy),
        pose_(world.start),
        measurement_noise_(2 * world.landmarks.size(), 0.0) {}

  const Pose& pose() const { return pose_; }

  Pose initial_error() const {
    Pose error = Pose::Zero();
    if (noisy_) source_.normals(0, 0, NoisePurpose::initial, {error.data(), 3});
    return error.cwiseProduct(noise_.initial_std);
  }

  Eigen::Matrix3d initial_covariance() const { return noise_.initial_std.cwiseAbs2().asDiagonal(); }

  void move(Index step, const Control& nominal) {
    Control noise = Control::Zero();
    if (noisy_) source_.normals(0, step, NoisePurpose::process, {noise.data(), 2});
    pose_ = world_.vehicle.moved(pose_, nominal + noise.cwiseProduct(noise_.control_std), world_.dt_s);
  }

  std::vector<Observation<PlanarModel>> observe(Index step) {
    if (noisy_) source_.normals(0, step, NoisePurpose::measurement, measurement_noise_);
    std::vector<Observation<PlanarModel>> seen;
    for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
      if (!world_.sees(pose_, world_.landmarks[i])) continue;
      RangeBearing z = measure_range_bearing(pose_, world_.landmarks[i]);
      z[0] += noise_.measurement_std[0] * measurement_noise_[2 * i];
      z[1] = wrap_angle(z[1] + noise_.measurement_std[1] * measurement_noise_[2 * i + 1]);
      seen.push_back({static_cast<int>(i), z});
    }
    return seen;
  }

 private:
  const PlanarWorld& world_;
  PlanarNoise noise_;
  NoiseSource source_;
  bool noisy_;
  Pose pose_;
  std::vector<double> measurement_noise_;
};

/// H of what is known of `seen`, at the filter's estimate, in the filter's own order.
Matrix measurement_jacobian(const PlanarFilter& filter, const PlanarWorld& world,
                            const std::vector<Observation<PlanarModel>>& seen) {
  Matrix H = Matrix::Zero(2 * static_cast<Index>(seen.size()), filter.state().size());
  Index rows = 0;
  for (const Observation<PlanarModel>& o : seen) {
    const bool anchored = o.landmark >= world.states();
    const Index offset = anchored ? -1 : filter.offset_of(o.landmark);
    if (!anchored && offset < 0) continue;
    const Point landmark = anchored ? world.landmarks[static_cast<std::size_t>(o.landmark)]
                                    : Point(filter.state().segment<2>(offset));
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
      : rule_(make_inflation_rule(scenario)), world_(world), loop_(loop) {
    const PlanarNoise noise = PlanarNoise::of(scenario);
    Q_ = (scenario.filter.process_scale * noise.control_std.cwiseAbs2()).asDiagonal();
  }

  void begin(const PlanarFilter& filter) {
    loop_.layout = filter.layout();
    loop_.start = filter.state();
    loop_.H.emplace_back(0, filter.state().size());
  }

  void before_predict(const PlanarFilter& filter, const Control& u) {
    const Index n = filter.state().size();
    const Motion motion = world_.vehicle.move(filter.pose(), u, world_.dt_s);
    loop_.F.push_back(Matrix::Identity(n, n));
    loop_.F.back().topLeftCorner<3, 3>() = motion.F;
    loop_.process.push_back(Matrix::Zero(n, n));
    loop_.process.back().topLeftCorner<3, 3>() = motion.G * Q_ * motion.G.transpose();
  }

  void before_update(const PlanarFilter& filter, const std::vector<Observation<PlanarModel>>& seen) {
    loop_.H.push_back(measurement_jacobian(filter, world_, seen));
    Matrix inflated = filter.covariance();
    if (!rule_.is_sequential()) inflate(inflated, filter.layout(), rule_.inflation, rule_.solution, state_);
    loop_.inflation.push_back(inflated - filter.covariance());
  }

  void after_update(const PlanarFilter& filter) {
    const bool none = loop_.H.back().rows() == 0;
    loop_.K.push_back(none ? Matrix(filter.state().size(), 0) : filter.gain());
  }

 private:
  InflationRule rule_;
  const PlanarWorld& world_;
  PlanarLoopRecord& loop_;
  Eigen::Matrix2d Q_;
  MinTraceState state_;
};

}  // namespace

Index planar_steps_per_loop(const Scenario& scenario) {
  const WorldSettings& w = scenario.world;
  return static_cast<Index>(std::ceil(loop_length_m(w.path, w.path_radius) / (w.speed * w.dt) - 1e-9));
}

PlanarPathRun follow_planar_path(const Scenario& scenario, Index loops, Linearisation at) {
  const Index per_loop = planar_steps_per_loop(scenario), steps = loops * per_loop;
  const Index before_last = steps - per_loop;
  Scenario longer = scenario;
  longer.study.steps = steps;
  PlanarPathRun run;
  run.world = make_planar_world(longer);
  Drive drive(run.world, longer, at == Linearisation::estimate);
  PlanarFilter filter = make_planar_filter(longer, run.world);
  Pose initial = drive.pose() + drive.initial_error();
  PlanarModel::wrap_pose(initial);
  filter.reset(initial, drive.initial_covariance());
  Recorder recorder(longer, run.world, run.loop);
  StateError error;
  double nees = 0.0, trace = 0.0;
  const Index second_half = steps / 2;
  for (Index k = 1; k <= steps; ++k) {
    const Control& u = run.world.controls[static_cast<std::size_t>(k - 1)];
    const bool all_known = static_cast<Index>(filter.landmarks().size()) == run.world.states();
    if (k == before_last + 1 && all_known) recorder.begin(filter);
    const bool recording = k > before_last && !run.loop.H.empty();
    drive.move(k, u);
    const std::vector<Observation<PlanarModel>> seen = drive.observe(k);
    if (recording) recorder.before_predict(filter, u);
    filter.predict(u);
    if (recording) recorder.before_update(filter, seen);
    const UpdateResult update = filter.update(seen);
    run.ok = update.ok && filter.state().allFinite() &&
             error.compute(drive.pose(), run.world.landmarks, filter.state(), filter.covariance(),
                           filter.landmarks()) == Outcome::ok;
    if (!run.ok) break;
    if (recording) recorder.after_update(filter);
    run.not_converged += update.converged ? 0 : 1;
    if (k > second_half) nees += error.vehicle_nees / 3.0;
    trace += filter.covariance().trace();
    if (k % per_loop == 0) {
      run.traces.push_back(trace / static_cast<double>(per_loop));
      trace = 0.0;
    }
  }
  run.pose_nees = at == Linearisation::truth ? kNaN : nees / static_cast<double>(steps - second_half);
  return run;
}

}  // namespace credence
