#include "montecarlo/worlds/tracking/range_bearing_tracking.h"

#include <Eigen/Cholesky>
#include <optional>

#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/psd_root.h"
#include "core/manifold/angle.h"
#include "core/stop_point.h"
#include "montecarlo/engine/run_loop.h"
#include "montecarlo/random/delay_line.h"
#include "montecarlo/random/step_draws.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/linear/linear_trace.h"
#include "montecarlo/worlds/plugged/function_bound.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"
#include "montecarlo/worlds/tracking/tracking_world.h"

namespace credence::internal {
namespace {

constexpr Index kStates = 4;

Matrix variances(const RangeBearing& std, double scale) {
  return Matrix((scale * std.cwiseAbs2()).asDiagonal());
}

RunLayout layout_of(const Scenario& scenario, const Matrix& R) {
  RunLayout layout = target_layout(scenario, R);
  Sensor& sensor = layout.sensors.front();
  sensor.piece = 2;  // a step is measured as a whole
  sensor.variances = {R(0, 0), R(1, 1)};
  sensor.angles = {false, true};
  layout.nonlinear = true;
  return layout;
}

RangeBearing measurement_std_of(const Scenario& scenario) {
  return {scenario.noise.range_std, scenario.noise.bearing_std_deg * kRadiansPerDegree};
}

}  // namespace

/// One run of target and filter.
class RangeBearingTracking::Run {
 public:
  explicit Run(const RangeBearingTracking& e)
      : e_(e),
        Q_(e.process_scale_ * e.motion_.Q),
        R_(variances(e.measurement_std_, e.measurement_scale_)),
        noise_root_(psd_root(e.motion_.Q)),
        initial_root_(psd_root(e.motion_.P0)),
        process_(StepDraws::normals(e.source_, NoisePurpose::process, kStates)),
        measurement_(StepDraws::normals(e.source_, NoisePurpose::measurement, 2)),
        detection_(StepDraws::events(e.source_, NoisePurpose::detection, e.detection_probability_, 1)),
        line_(e.delay_) {
    name_states(e.motion_.layout, now_);
  }

  void start(std::int64_t run) {
    for (StepDraws* draws : {&process_, &measurement_, &detection_}) draws->start(run);
    line_.clear();
    Vector error(kStates);
    e_.source_.normals(run, 0, NoisePurpose::initial, {error.data(), static_cast<std::size_t>(kStates)});
    estimate_ = e_.start_;
    const Vector x = e_.start_ + initial_root_ * error;
    set_error(x, x - estimate_, now_);
    now_.P = e_.motion_.P0;
  }

  Outcome step(Index k) {
    stop_point();
    now_.step = k;
    const Matrix& F = e_.motion_.F;
    const Vector x = F * now_.truth + noise_root_ * Eigen::Map<const Vector>(process_.at(k), kStates);
    estimate_ = F * estimate_;
    Matrix P = F * now_.P * F.transpose() + Q_;
    symmetrise(P);
    const Vector before = P.diagonal();
    trace_prior_ = before.sum();
    now_.nis_dof = 0;
    now_.nis = 0.0;
    now_.innovations.front() = {};
    now_.K.resize(0, 0);
    now_.z.resize(0);
    const std::optional<Seen> seen = line_.pass(measure(x, k));
    if (seen && *seen && !update(**seen, P)) {
      return Outcome::not_positive_definite;
    }
    if (!estimate_.allFinite()) return Outcome::diverged;
    set_error(x, x - estimate_, now_);
    now_.P = P;
    const Matrix whitening = psd_whitening(P, before);
    now_.nees = (whitening * now_.error).squaredNorm();
    now_.nees_dof = whitening.rows();
    return Outcome::ok;
  }

  const TraceStep& now() const { return now_; }

  void show(ChunkObserver& observer, Index) const { observer.add(now_, 0); }

  void add_to(StepStatistics& s, RunTotals& sums) const {
    sums.whole.add(now_.nees, now_.nees_dof);
    s[Quantity::nees].add(now_.nees);
    if (now_.nis_dof > 0) s[Quantity::nis].add(now_.nis);
    s.nees_dof += now_.nees_dof;
    s.nis_dof += now_.nis_dof;
    s[Quantity::trace_prior].add(trace_prior_);
    s[Quantity::trace].add(now_.P.trace());
    s[Quantity::trace_vehicle].add(now_.P(0, 0) + now_.P(1, 1));
    s[Quantity::position_error_squared].add(now_.error.head<2>().squaredNorm());
  }

 private:
  using Seen = std::optional<RangeBearing>;

  Seen measure(const Vector& x, Index k) {
    if (detection_.at(k)[0] == 0.0) return std::nullopt;
    RangeBearing z = measure_range_bearing(Pose::Zero(), x.head<2>());
    z += e_.measurement_std_.cwiseProduct(Eigen::Map<const RangeBearing>(measurement_.at(k)));
    z[1] = wrap_angle(z[1]);
    return z;
  }

  /// The extended Kalman filter's update in Joseph's form; false where S is not positive definite.
  bool update(const RangeBearing& z, Matrix& P) {
    now_.z = z;
    const PredictedRangeBearing predicted = predict_range_bearing(Pose::Zero(), estimate_.head<2>());
    Matrix H = Matrix::Zero(2, kStates);
    H.leftCols<2>() = predicted.H_l;
    const Matrix S = H * P * H.transpose() + R_;
    const Eigen::LLT<Matrix> llt(S);
    if (!S.allFinite() || llt.info() != Eigen::Success) return false;
    const Vector nu = range_bearing_innovation(z, predicted.z);
    now_.K = llt.solve(H * P).transpose();
    estimate_ += now_.K * nu;
    const Matrix A = Matrix::Identity(kStates, kStates) - now_.K * H;
    P = (A * P * A.transpose() + now_.K * R_ * now_.K.transpose()).eval();
    symmetrise(P);
    now_.innovations.front() = {nu, S};
    now_.nis = nu.dot(llt.solve(nu));
    now_.nis_dof = 2;
    return true;
  }

  const RangeBearingTracking& e_;
  Matrix Q_, R_, noise_root_, initial_root_;
  StepDraws process_, measurement_, detection_;
  DelayLine<Seen> line_;
  Vector estimate_;
  double trace_prior_ = 0.0;
  TraceStep now_;
};

RangeBearingTracking::RangeBearingTracking(const Scenario& scenario, NoiseSource source)
    : ShownExperiment(
          layout_of(scenario, variances(measurement_std_of(scenario), scenario.filter.measurement_scale))),
      motion_(target_model(scenario)),
      start_(target_start(scenario)),
      measurement_std_(measurement_std_of(scenario)),
      detection_probability_(scenario.noise.detection_probability),
      process_scale_(scenario.filter.process_scale),
      measurement_scale_(scenario.filter.measurement_scale),
      delay_(measurement_delay(scenario)),
      steps_(scenario.study.steps),
      source_(source) {}

StudyStatistics RangeBearingTracking::play(std::int64_t first_run, std::int64_t runs,
                                           ChunkObserver* observer) const {
  Run run(*this);
  return play_runs(run, first_run, runs, steps_, observer);
}

Outcome RangeBearingTracking::visit(std::int64_t run_number, const StepVisitor& take) const {
  Run run(*this);
  run.start(run_number);
  return visit_steps(
      steps_, take, [&](Index k) { return run.step(k); }, [&] { return run.now(); });
}

PosteriorBound range_bearing_bound(const Scenario& scenario) {
  const LinearModel motion = target_model(scenario);
  FunctionModel model;
  model.f = [F = motion.F](const Vector& x) { return Vector(F * x); };
  model.F = [F = motion.F](const Vector&) { return F; };
  model.h = [](const Vector& x) { return Vector(measure_range_bearing(Pose::Zero(), x.head<2>())); };
  model.H = [](const Vector& x) {
    Matrix H = Matrix::Zero(2, kStates);
    H.leftCols<2>() = predict_range_bearing(Pose::Zero(), x.head<2>()).H_l;
    return H;
  };
  model.Q = motion.Q;
  model.R = variances(measurement_std_of(scenario), 1.0);
  model.mean = target_start(scenario);
  model.P0 = motion.P0;
  model.states = {"position.x", "position.y", "velocity.x", "velocity.y"};
  return posterior_bound(model, plug_settings(scenario), scenario.noise.detection_probability);
}

}  // namespace credence::internal
