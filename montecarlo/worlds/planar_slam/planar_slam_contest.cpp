#include "core/filters/estimators/estimators.h"
#include "core/filters/estimators/jacobian_rows.h"
#include "core/names_in.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/best_time.h"
#include "montecarlo/worlds/contest_player.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"
#include "montecarlo/worlds/planar_slam/odometry_bound.h"

namespace credence::internal {
namespace {

/// What is judged of one estimator, with the memory that this takes.
class StepJudge {
 public:
  EstimatorStep judge(const EstimatorRun& run, bool with_map) {
    using enum EstimatorBlock;
    const SlamEstimator& filter = run.filter();
    const MatrixRef P = filter.covariance();
    const Eigen::Matrix3d P_plane = filter.plane_pose_covariance();
    const VectorRef e = run.error(), x = filter.state();
    const Pose plane = run.plane_error();
    EstimatorStep step;
    step[chart_position] = solve(e.head(2), P.topLeftCorner(2, 2), x.head(2));
    step[heading] = solve(e.segment(2, 1), P.block(2, 2, 1, 1), x.segment(2, 1));
    step[pose] = solve(e.head(3), P.topLeftCorner(3, 3), x.head(3));
    if (filter.chart() == ErrorChart::plane) {
      step[position] = step[chart_position];
      step[plane_pose] = step[pose];
    } else {
      step[position] = solve(plane.head<2>(), P_plane.topLeftCorner<2, 2>(), x.head(2));
      step[plane_pose] = solve(plane, P_plane, x.head(3));
    }
    const Index n = filter.size();
    if (with_map && n > 3)
      step[map] = map_solver_.solve(e.tail(n - 3), P.bottomRightCorner(n - 3, n - 3), x.tail(n - 3));
    step.converged = run.update().converged;
    step.heading_squared = plane[2] * plane[2];
    step.position_squared = plane.head<2>().squaredNorm();
    step.heading_variance = P_plane(2, 2);
    step.position_variance = P_plane(0, 0) + P_plane(1, 1);
    return step;
  }

 private:
  NeesValue solve(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate) {
    return solver_[static_cast<std::size_t>(error.size())].solve(error, P, estimate);
  }

  std::array<SingularNees, 4> solver_;  ///< by dimension, so that none changes its size
  SingularNees map_solver_;
};

class PlanarSlamContest final : public EstimatorContest {
 public:
  explicit PlanarSlamContest(const Scenario& scenario)
      : scenario_(scenario), world_(make_odometry_world(scenario)), source_(noise_source(scenario)) {}

  Index steps() const override { return std::ssize(world_.plane.controls); }
  std::unique_ptr<EstimatorPlayer> player(std::span<const std::string> names) const override {
    std::vector<EstimatorRun> runs;
    for (const std::string& name : names) {
      runs.emplace_back(world_, scenario_estimator(scenario_, world_, name));
    }
    auto judge = [judges = std::vector<StepJudge>(names.size())](std::size_t e, const EstimatorRun& run,
                                                                 bool with_map) mutable {
      return judges[e].judge(run, with_map);
    };
    return contest_player(*this, OdometrySimulation(world_, source_), std::move(runs), std::move(judge));
  }
  EstimatorProfile profile(std::string_view name, const TakeRow& take_row) const override;
  Index unknowns() const override { return 3 + 2 * world_.plane.states(); }
  VehicleBound bound() const override {
    const PosteriorBound bound = odometry_bound(world_);
    return {bound.mean_bound("heading"), bound.mean_bound("position")};
  }
  std::string note() const override {
    return "A shift and a turn of the plane are 3 unobservable directions.";
  }

 private:
  Scenario scenario_;
  OdometryWorld world_;
  NoiseSource source_;
};

EstimatorProfile PlanarSlamContest::profile(std::string_view name, const TakeRow& take_row) const {
  OdometrySimulation simulation(world_, source_);
  const Pose estimate = simulation.start(0);
  std::vector<Control> read;
  std::vector<std::vector<Observation<PlanarModel>>> seen;
  for (std::size_t k = 1; k <= world_.plane.controls.size(); ++k) {
    read.push_back(simulation.read(k));
    const auto now = simulation.observe(k);
    seen.emplace_back(now.begin(), now.end());
  }
  const auto filter = scenario_estimator(scenario_, world_, name);
  JacobianRows rows(unknowns());
  std::size_t played = 0;  // a filter may fail
  const auto play = [&](bool show) {
    filter->reset(estimate, world_.noise.initial_covariance());
    for (std::size_t k = 1; k <= read.size(); ++k) {
      stop_point();
      played = k;
      const PlanarTruth truth = world_.truth(k);
      filter->predict(read[k - 1], truth);
      const UpdateResult update = filter->update(seen[k - 1], truth);
      if (!update.ok || !filter->state().allFinite()) break;
      if (show) rows.add(*filter, take_row);
    }
  };
  play(true);
  const double seconds = best_time(3, [&] { play(false); });
  EstimatorProfile profile{.known = rows.states(), .seconds_per_step = seconds / static_cast<double>(played)};
  if (filter->chart() == ErrorChart::right_invariant) {
    profile.chart = "right_invariant";
    profile.chart_text = "log(X̂ X⁻¹) in SE(2) with the landmarks";
  }
  return profile;
}

std::vector<std::string_view> planar_names(const Scenario*) { return names_in(estimator_kinds()); }

std::unique_ptr<EstimatorContest> planar_contest(const Scenario& scenario) {
  return std::make_unique<PlanarSlamContest>(scenario);
}

}  // namespace

constinit const EstimatorOffer kPlanarSlamOffer = {.names = planar_names, .contest = planar_contest};

}  // namespace credence::internal
