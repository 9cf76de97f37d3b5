#include "montecarlo/worlds/planar_slam/estimator_run.h"

#include <cmath>

#include "core/manifold/angle.h"
#include "core/record/certain_states.h"
#include "core/record/normalised_error.h"
#include "core/stop_point.h"

namespace credence::internal {

NeesValue SingularNees::solve(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate) {
  leaves_range_ = false;
  find_certain_states(estimate, error, P, certain_);
  if (certain_.empty() && (P.diagonal().array() > 0.0).all()) {
    const NeesValue nees = solver_.solve(error, P);
    if (nees.dof >= 0 && std::isfinite(nees.value) && solver_.well_conditioned(P)) return nees;
  }
  Vector known_error = error;
  Matrix known_P = P.selfadjointView<Eigen::Lower>();
  make_certain(certain_, known_error, known_P);
  const NormalisedError nees = normalised_error(known_error, known_P);
  if (!nees.ok) return {0.0, -1};
  leaves_range_ = std::isinf(nees.value);
  return {nees.whitened.squaredNorm(), nees.dof};
}

NeesValue SingularNees::judge(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate) {
  const NeesValue nees = solve(error, P, estimate);
  return leaves_range_ ? NeesValue{0.0, 0} : nees;
}

EstimatorRun::EstimatorRun(const OdometryWorld& world, std::unique_ptr<SlamEstimator> filter)
    : world_(world), filter_(std::move(filter)) {
  error_.resize(3 + 2 * world.plane.states());
}

void EstimatorRun::start(const Pose& estimate) {
  filter_->reset(estimate, world_.noise.initial_covariance());
  step_ = 0;
  update_ = {};
  filter_->error(truth(), error_.head(3));
}

Outcome EstimatorRun::step(std::size_t k, const Control& read,
                           std::span<const Observation<PlanarModel>> seen) {
  stop_point();
  step_ = k;
  const PlanarTruth truth = world_.truth(k);
  filter_->predict(read, truth);
  update_ = filter_->update(seen, truth);
  if (!filter_->state().allFinite()) return Outcome::diverged;
  if (!update_.ok) return Outcome::not_positive_definite;
  filter_->error(truth, error_.head(filter_->size()));
  return plane_error().head<2>().norm() > world_.width_m ? Outcome::diverged : Outcome::ok;
}

Pose EstimatorRun::plane_error() const {
  Pose error = filter_->state().head<3>() - world_.path[step_];
  error[2] = wrap_angle(error[2]);
  return error;
}

}  // namespace credence::internal
