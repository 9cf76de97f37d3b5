#include "montecarlo/worlds/planar_slam/planar_slam_experiment.h"

#include "montecarlo/engine/run_loop.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "montecarlo/worlds/planar/planar_step.h"
#include "montecarlo/worlds/planar/state_error.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence::internal {
namespace {

RunLayout layout_of(const Scenario& scenario, const OdometryWorld& world) {
  RunLayout layout = planar_layout(world.plane);
  layout.componentwise = scenario_estimator(scenario, world)->chart() == ErrorChart::plane;
  layout.sensors.front().angles = {false, world.sensor.kind == LandmarkSensorKind::range_bearing};
  return layout;
}

}  // namespace

/// One run, with what the statistics take of each step.
class PlanarSlamExperiment::Run {
 public:
  explicit Run(const PlanarSlamExperiment& e)
      : simulation_(e.world_, e.source_),
        run_(e.world_, scenario_estimator(e.scenario_, e.world_)),
        world_(e.world_) {}

  void start(std::int64_t run) {
    run_.start(simulation_.start(run));
    step_ = {};
  }

  Outcome step(Index number) {
    const auto k = static_cast<std::size_t>(number);
    const Outcome outcome = run_.step(k, simulation_.read(k), simulation_.observe(k));
    step_.update = run_.update();
    if (outcome != Outcome::ok) return outcome;
    const SlamEstimator& filter = run_.filter();
    const Index n = filter.size();
    const MatrixRef P = filter.covariance();
    const VectorRef x = filter.state();
    const NeesValue whole = solver_.judge(run_.error(), P, x);
    const NeesValue pose =
        whole.dof == 0 ? whole : pose_solver_.judge(run_.error().head(3), P.topLeftCorner(3, 3), x.head(3));
    if (whole.dof < 0 || pose.dof < 0) return Outcome::not_positive_definite;
    step_.nees = whole.value;
    step_.nees_dof = whole.dof;
    step_.vehicle_nees = pose.value;
    step_.vehicle_dof = pose.dof;
    const Eigen::Matrix3d in_plane = filter.plane_pose_covariance();
    step_.traces.position = in_plane(0, 0) + in_plane(1, 1);
    step_.traces.heading = in_plane(2, 2);
    step_.traces.landmarks = P.diagonal().tail(n - 3).sum();
    step_.traces.all = P.diagonal().sum();
    const Pose error = run_.plane_error();
    step_.position_error_squared = error.head<2>().squaredNorm();
    step_.heading_error_squared = error[2] * error[2];
    step_.map_error_squared = 0.0;
    step_.landmarks = (n - 3) / 2;
    for (std::size_t i = 0; i < filter.landmarks().size(); ++i) {
      const Point& l = world_.plane.landmarks[static_cast<std::size_t>(filter.landmarks()[i])];
      step_.map_error_squared += (filter.state().segment<2>(3 + 2 * static_cast<Index>(i)) - l).squaredNorm();
    }
    return Outcome::ok;
  }

  void add_to(StepStatistics& s, RunTotals& sums) const { step_.add_to(s, sums); }

  void show(ChunkObserver& observer, Index k) {
    shown_.step = k;
    tell(shown_);
    observer.add(shown_, 0);
  }

  /// What evidence looks at.
  void tell(Step& step) const {
    const SlamEstimator& filter = run_.filter();
    step.estimate = filter.state();
    slam_states({.vehicle = 3, .landmark = 2, .landmarks = world_.plane.states()}, filter.landmarks(),
                step.states);
    step.error = run_.error();
    step.P = filter.covariance().selfadjointView<Eigen::Lower>();
    step.innovations.resize(1);
    Innovation& innovation = step.innovations.front();
    if (step_.update.dof > 0) {
      innovation.nu = filter.innovation();
      innovation.S = filter.innovation_covariance();
    } else {
      innovation.nu.resize(0);
      innovation.S.resize(0, 0);
    }
  }

  TraceStep trace_step() const {
    const SlamEstimator& filter = run_.filter();
    TraceStep step;
    tell(step);
    step.landmarks.assign(filter.landmarks().begin(), filter.landmarks().end());
    step.truth = true_state(run_.truth().now, world_.plane.landmarks, step.landmarks);
    step.nees = step_.nees;
    step.nees_dof = step_.nees_dof;
    step.nis = step_.update.nis;
    step.nis_dof = step_.update.dof;
    if (step_.update.dof > 0) {
      step.K = Matrix::Zero(filter.size(), step_.update.dof);  // of landmarks just placed: none
      const Matrix K = filter.gain();
      step.K.topRows(K.rows()) = K;
    }
    return step;
  }

 private:
  OdometrySimulation simulation_;
  EstimatorRun run_;
  const OdometryWorld& world_;
  PlanarStep step_;
  Step shown_;
  SingularNees solver_, pose_solver_;
};

PlanarSlamExperiment::PlanarSlamExperiment(const Scenario& scenario, const NoiseSource& source,
                                           OdometryWorld world)
    : ShownExperiment(layout_of(scenario, world)),
      scenario_(scenario),
      world_(std::move(world)),
      source_(source) {
  const auto R = estimator_settings(scenario_, world_).R;
  assume_measurement_variances({R(0, 0), R(1, 1)});
}

StudyStatistics PlanarSlamExperiment::play(std::int64_t first_run, std::int64_t runs,
                                           ChunkObserver* observer) const {
  Run run(*this);
  return play_runs(run, first_run, runs, std::ssize(world_.plane.controls), observer);
}

Outcome PlanarSlamExperiment::visit(std::int64_t run_number, const StepVisitor& take) const {
  Run run(*this);
  run.start(run_number);
  return visit_steps(
      std::ssize(world_.plane.controls), take, [&](Index k) { return run.step(k); },
      [&] { return run.trace_step(); });
}

RunTrace PlanarSlamExperiment::describe_world() const { return describe_planar_world(world_.plane); }

}  // namespace credence::internal
