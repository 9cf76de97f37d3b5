#include <Eigen/QR>
#include <map>

#include "core/names_in.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/best_time.h"
#include "montecarlo/worlds/contest_player.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"
#include "montecarlo/worlds/spatial_slam/spatial_bound.h"
#include "montecarlo/worlds/spatial_slam/spatial_run.h"

namespace credence::internal {
namespace {

constexpr Index kUnknowns = 7;            // the pose, and a measure of rounding
constexpr Index kSpatialMapStride = 100;  // its Cholesky factor costs as much as ten steps

/// What is judged of one estimator after the other, with the memory that this takes.
class SpatialJudge {
 public:
  EstimatorStep operator()(std::size_t, const SpatialRun& run, bool with_map) {
    using enum EstimatorBlock;
    const SpatialSlam& filter = run.filter();
    const SpatialTruth truth = run.truth();
    const auto plane = filter.pose_error(truth.now, false), own = filter.pose_error(truth.now, true);
    const SpatialSlam::PoseMatrix P = filter.pose_covariance(), P_own = filter.own_pose_covariance();
    EstimatorStep step;
    step[pose] = solver_.solve(own, P_own);
    step[plane_pose] = solver_.solve(plane, P);
    step[heading] = solver_.solve(plane.tail<3>(), P.bottomRightCorner<3, 3>());
    step[position] = solver_.solve(plane.head<3>(), P.topLeftCorner<3, 3>());
    step[chart_position] = solver_.solve(own.head<3>(), P_own.topLeftCorner<3, 3>());
    if (with_map && filter.size() > 6) {
      const SpatialSlam::MapError of_map = filter.map_error(truth);
      step[map] = map_solver_.solve(of_map.error, of_map.P);
    }
    step.heading_squared = plane.tail<3>().squaredNorm();
    step.position_squared = plane.head<3>().squaredNorm();
    step.heading_variance = P.diagonal().tail<3>().sum();
    step.position_variance = P.diagonal().head<3>().sum();
    return step;
  }

 private:
  SingularNees solver_, map_solver_;
};

/// What the rows of a run tell of the pose at its start once each landmark has been eliminated: of the rows
/// [A, B] of one landmark those of Qᵀ A that Qᵀ B leaves empty. What the whole stack does not tell is what
/// these do not tell. One more unknown, told with unit weight, is the measure of what is rounding.
class EliminatedRows {
 public:
  void add(const SpatialSlam& filter) {
    transition_ = filter.motion_jacobian() * transition_;
    for (const SpatialRows& row : filter.rows()) {
      Kept& kept = kept_[row.landmark];
      kept.rows.conservativeResize(kept.rows.rows() + 3, 9);
      kept.rows.bottomRows<3>() << row.own, row.pose * transition_;
      if (kept.rows.rows() > 60) kept.reduce();
    }
  }
  void hand_on(const EstimatorContest::TakeRow& take_row) {
    for (auto& [number, kept] : kept_) {
      kept.reduce();
      for (Index r = 3; r < kept.rows.rows(); ++r) {
        Vector row = Vector::Zero(kUnknowns);
        row.head<6>() = kept.rows.row(r).tail<6>().transpose();
        take_row(row);
      }
    }
    take_row(Vector::Unit(kUnknowns, kUnknowns - 1));
  }

 private:
  struct Kept {
    Eigen::Matrix<double, Eigen::Dynamic, 9> rows{0, 9};
    void reduce() {
      const Eigen::HouseholderQR<Matrix> qr{Matrix(rows)};
      const Matrix R = qr.matrixQR().topRows(std::min<Index>(rows.rows(), 9)).triangularView<Eigen::Upper>();
      rows = R;
    }
  };
  SpatialSlam::PoseMatrix transition_ = SpatialSlam::PoseMatrix::Identity();
  std::map<int, Kept> kept_;
};

class SpatialContest final : public EstimatorContest {
 public:
  explicit SpatialContest(const Scenario& scenario)
      : world_(make_spatial_world(scenario)), source_(noise_source(scenario)) {}

  Index steps() const override { return world_.steps(); }
  Index map_stride() const override { return kSpatialMapStride; }
  std::unique_ptr<EstimatorPlayer> player(std::span<const std::string> names) const override {
    std::vector<SpatialRun> runs;
    for (const std::string& name : names) runs.emplace_back(world_, spatial_kind(name));
    return contest_player(*this, SpatialSimulation(world_, source_), std::move(runs), SpatialJudge());
  }
  EstimatorProfile profile(std::string_view name, const TakeRow& take_row) const override;
  Index unknowns() const override { return kUnknowns; }
  VehicleBound bound() const override {
    const PosteriorBound bound = spatial_bound(world_);
    return {bound.mean_bound("attitude"), bound.mean_bound("position")};
  }
  std::string note() const override {
    return "Heading: the whole attitude, 3 dof. A shift and a turn of space are 6 unobservable directions.";
  }

 private:
  SpatialWorld world_;
  NoiseSource source_;
};

EstimatorProfile SpatialContest::profile(std::string_view name, const TakeRow& take_row) const {
  SpatialSimulation simulation(world_, source_);
  const SE3 estimate = simulation.start(0);
  std::vector<SpatialControl> read;
  std::vector<std::vector<SpatialObservation>> seen;
  for (std::size_t k = 1; k <= world_.controls.size(); ++k) {
    read.push_back(simulation.read(k));
    const auto now = simulation.observe(k);
    seen.emplace_back(now.begin(), now.end());
  }
  SpatialRun run(world_, spatial_kind(name));
  EliminatedRows rows;
  std::size_t played = 0;  // a filter may fail
  const auto play = [&](bool show) {
    run.start(estimate);
    for (std::size_t k = 1; k <= read.size(); ++k) {
      played = k;
      if (run.step(k, read[k - 1], seen[k - 1]) != Outcome::ok) break;
      if (show) rows.add(run.filter());
    }
  };
  play(true);
  const double seconds = best_time(1, [&] { play(false); });
  rows.hand_on(take_row);
  EstimatorProfile profile{.known = unknowns(), .seconds_per_step = seconds / static_cast<double>(played)};
  switch (spatial_kind(name).chart) {
    case SpatialChart::componentwise: break;
    case SpatialChart::pose:
      profile.chart = "pose_left";
      profile.chart_text = "log(X X̂⁻¹) in SE(3) for the pose, x̂ − x for landmarks";
      break;
    case SpatialChart::whole:
      profile.chart = "right_invariant";
      profile.chart_text = "log(X X̂⁻¹) in SE(3) with the landmarks";
      break;
  }
  return profile;
}

std::vector<std::string_view> spatial_names(const Scenario*) { return names_in(spatial_kinds()); }

std::unique_ptr<EstimatorContest> spatial_contest(const Scenario& scenario) {
  return std::make_unique<SpatialContest>(scenario);
}

}  // namespace

constinit const EstimatorOffer kSpatialOffer = {.names = spatial_names, .contest = spatial_contest};

}  // namespace credence::internal
