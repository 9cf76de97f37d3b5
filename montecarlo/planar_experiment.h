#pragma once

#include <functional>

#include "core/angle.h"
#include "montecarlo/experiment.h"
#include "montecarlo/noise.h"
#include "montecarlo/planar_world.h"
#include "montecarlo/slam_filter.h"
#include "montecarlo/state_error.h"

namespace credence {

/// Standard deviations of the true noise of a planar world.
struct PlanarNoise {
  Control control_std;           ///< in the units of the vehicle's control
  RangeBearing measurement_std;  ///< m, rad
  Pose initial_std;              ///< m, m, rad

  static PlanarNoise of(const Scenario& scenario);
};

/// Many runs of one filter in one planar world.
///
/// The vehicle drives its nominal controls plus noise, from the nominal start; the filter starts at the truth
/// plus an error of the initial covariance, is told the nominal controls, and sees every landmark in range.
/// F is any PlanarSlamFilter; `make_filter` gives a fresh one and must be safe to call from several threads.
template <PlanarSlamFilter F>
class PlanarExperiment final : public Experiment {
 public:
  PlanarExperiment(PlanarWorld world, const PlanarNoise& noise, NoiseSource source,
                   std::function<F()> make_filter)
      : world_(std::move(world)), noise_(noise), source_(source), make_filter_(std::move(make_filter)) {}

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override {
    StudyStatistics statistics;
    statistics.steps.resize(world_.controls.size());
    statistics.runs = runs;
    F filter = make_filter_();
    Run run(*this, filter);
    for (std::int64_t r = first_run; r < first_run + runs; ++r) {
      run.start(r);
      for (std::size_t k = 1; k <= world_.controls.size(); ++k) {
        const Outcome outcome = run.step(k);
        if (outcome != Outcome::ok) {
          statistics.failures.push_back({r, static_cast<std::int64_t>(k), outcome});
          break;
        }
        run.add_to(statistics.steps[k - 1]);
      }
    }
    return statistics;
  }

  Outcome visit(std::int64_t r, const StepVisitor& take) const override {
    F filter = make_filter_();
    Run run(*this, filter);
    run.start(r);
    take(run.trace_step());
    Outcome outcome = Outcome::ok;
    for (std::size_t k = 1; k <= world_.controls.size() && outcome == Outcome::ok; ++k) {
      outcome = run.step(k);
      TraceStep step = run.trace_step();
      // A step that failed has no statistics: its numbers would be those of the step before.
      if (outcome != Outcome::ok) step.nees_dof = step.nis_dof = 0;
      take(step);
    }
    return outcome;
  }

  RunTrace describe_world() const override {
    RunTrace trace{.vehicle_dim = 3, .landmark_dim = 2};
    trace.landmark_positions.resize(2, world_.states());
    trace.anchor_positions.resize(2, world_.anchors);
    for (Index i = 0; i < world_.states() + world_.anchors; ++i) {
      const Point& p = world_.landmarks[static_cast<std::size_t>(i)];
      if (i < world_.states()) {
        trace.landmark_positions.col(i) = p;
      } else {
        trace.anchor_positions.col(i - world_.states()) = p;
      }
    }
    return trace;
  }

 private:
  /// The state of a run, its buffers kept from run to run.
  class Run {
   public:
    Run(const PlanarExperiment& experiment, F& filter)
        : e_(experiment), filter_(filter), measurement_noise_(2 * e_.world_.landmarks.size()) {
      observations_.reserve(e_.world_.landmarks.size());
    }

    void start(std::int64_t run) {
      run_ = run;
      truth_ = e_.world_.start;
      Pose initial;
      e_.source_.normals(run, 0, NoisePurpose::initial, {initial.data(), 3});
      Pose estimate = truth_ + initial.cwiseProduct(e_.noise_.initial_std);
      estimate[2] = wrap_angle(estimate[2]);
      filter_.reset(estimate, Eigen::Matrix3d(e_.noise_.initial_std.cwiseAbs2().asDiagonal()));
      update_ = {};
      error_.nees = 0.0;
      error_.dof = 0;
    }

    Outcome step(std::size_t k) {
      const Control& nominal = e_.world_.controls[k - 1];
      move_truth(k, nominal);
      observe(k);
      filter_.predict(nominal);
      update_ = filter_.update(observations_);
      if (!filter_.state().allFinite()) return Outcome::diverged;
      if (!update_.ok) return Outcome::not_positive_definite;
      return error_.compute(truth_, e_.world_.landmarks, filter_.state(), filter_.covariance(),
                            filter_.landmarks());
    }

    void add_to(StepStatistics& s) const {
      s[Quantity::nees].add(error_.nees);
      s.nees_dof += error_.dof;
      if (update_.dof > 0) s[Quantity::nis].add(update_.nis);
      s.nis_dof += update_.dof;
      s[Quantity::vehicle_nees].add(error_.vehicle_nees);
      const Matrix& P = filter_.covariance();
      const double vehicle = P(0, 0) + P(1, 1);
      const double trace = P.trace();
      s[Quantity::trace_prior].add(update_.trace_prior);
      s[Quantity::trace].add(trace);
      s[Quantity::trace_vehicle].add(vehicle);
      s[Quantity::trace_landmarks].add(trace - vehicle - P(2, 2));
      s[Quantity::position_error_squared].add(error_.error.head<2>().squaredNorm());
      s[Quantity::heading_error_squared].add(error_.error[2] * error_.error[2]);
      const Index n = error_.error.size();
      if (n > 3) {
        s[Quantity::landmark_error_squared].add(2.0 * error_.error.tail(n - 3).squaredNorm() /
                                                static_cast<double>(n - 3));
      }
    }

    TraceStep trace_step() const {
      TraceStep step;
      step.estimate = filter_.state();
      step.truth = true_state(truth_, e_.world_.landmarks, filter_.landmarks());
      step.P = filter_.covariance();
      step.nees = error_.nees;
      step.nees_dof = error_.dof;
      step.nis = update_.nis;
      step.nis_dof = update_.dof;
      step.landmarks.assign(filter_.landmarks().begin(), filter_.landmarks().end());
      if (update_.dof > 0) {
        step.innovation = filter_.innovation();
        step.S = filter_.innovation_covariance();
        step.K = filter_.gain();
      }
      return step;
    }

   private:
    void move_truth(std::size_t k, const Control& nominal) {
      Control noise;
      e_.source_.normals(run_, static_cast<std::int64_t>(k), NoisePurpose::process, {noise.data(), 2});
      const Control u = nominal + noise.cwiseProduct(e_.noise_.control_std);
      truth_ = e_.world_.vehicle.moved(truth_, u, e_.world_.dt_s);
    }

    void observe(std::size_t k) {
      e_.source_.normals(run_, static_cast<std::int64_t>(k), NoisePurpose::measurement, measurement_noise_);
      observations_.clear();
      for (std::size_t i = 0; i < e_.world_.landmarks.size(); ++i) {
        const Point& landmark = e_.world_.landmarks[i];
        if (!e_.world_.sees(truth_, landmark)) continue;
        RangeBearing z = measure_range_bearing(truth_, landmark);
        z[0] += e_.noise_.measurement_std[0] * measurement_noise_[2 * i];
        z[1] = wrap_angle(z[1] + e_.noise_.measurement_std[1] * measurement_noise_[2 * i + 1]);
        observations_.push_back({static_cast<int>(i), z});
      }
    }

    const PlanarExperiment& e_;
    F& filter_;
    std::vector<double> measurement_noise_;
    std::vector<Observation<PlanarModel>> observations_;
    std::int64_t run_ = 0;
    Pose truth_ = Pose::Zero();
    UpdateResult update_;
    StateError error_;
  };

  PlanarWorld world_;
  PlanarNoise noise_;
  NoiseSource source_;
  std::function<F()> make_filter_;
};

/// The EKF-SLAM that a planar scenario describes, as its filter assumes the noise to be.
EkfSlam<PlanarModel> make_planar_filter(const Scenario& scenario, const PlanarWorld& world);

}  // namespace credence
