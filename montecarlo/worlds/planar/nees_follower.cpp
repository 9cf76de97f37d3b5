#include "montecarlo/worlds/planar/nees_follower.h"

#include <cmath>

#include "core/manifold/angle.h"

namespace credence::internal {

NeesFollower::NeesFollower(const EkfSlam<PlanarModel>& filter) : filter_(filter) {
  const Eigen::LLT<Eigen::Matrix2d> root(filter.measurement_noise());
  if (!filter.inflates() && root.info() == Eigen::Success) along_.emplace(filter.measurement_noise());
}

void NeesFollower::start(const Eigen::Matrix3d& P) {
  trusted_ = along_.has_value();
  has_value_ = false;
  if (along_) along_->reset(P);
}

Pose NeesFollower::prior(const Pose& truth) const {
  Pose error = filter_.pose() - truth;
  error[2] = wrap_angle(error[2]);
  return error;
}

void NeesFollower::step(const Pose& prior, const Vector& error) {
  has_value_ = false;
  if (!trusted_) return;
  along_->step(filter_, prior, error, filter_.rows().empty() ? 0.0 : filter_.innovation_log_determinant());
  dof_ = error.size();
  if (!along_->factor(filter_.pose_covariance().diagonal(), NeesSolver::least_pivot(dof_))) return;
  nees_ = along_->nees();
  has_value_ = std::isfinite(nees_);
}

void NeesFollower::check(const NeesValue& by_factor, const NeesSolver& solver) {
  if (!has_value_) return;
  trusted_ = by_factor.dof == dof_ && agree(nees_, by_factor.value, dof_) &&
             solver.well_conditioned(filter_.lower_covariance());
  has_value_ = trusted_;
}

}  // namespace credence::internal
