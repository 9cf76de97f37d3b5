#include "montecarlo/worlds/planar_slam/estimator_run.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/psd_root.h"
#include "core/manifold/angle.h"
#include "core/record/certain_states.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr double kLeastPivot = 1e-12;  // of a squared pivot or an eigenvalue, relative to its variance

/// Whether e lies in part where P claims certainty.
bool leaves_range(const Vector& e, const Matrix& P) {
  const Vector deviation = P.diagonal().cwiseSqrt();
  std::vector<Index> open;
  for (Index i = 0; i < e.size(); ++i) {
    if (deviation[i] > 0.0) {
      open.push_back(i);
    } else if (std::abs(e[i]) > kCertainError) {
      return true;
    }
  }
  if (open.empty()) return false;
  const Vector scale = deviation(open).cwiseInverse(), scaled = scale.cwiseProduct(e(open));
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scale.asDiagonal() * P(open, open) * scale.asDiagonal());
  const Index without = (eigen.eigenvalues().array() <= kLeastPivot * eigen.eigenvalues().maxCoeff()).count();
  const Vector beyond = eigen.eigenvectors().leftCols(without).transpose() * scaled;
  return beyond.lpNorm<Eigen::Infinity>() > kCertainError * std::max(1.0, scaled.lpNorm<Eigen::Infinity>());
}

}  // namespace

NeesValue SingularNees::solve(const VectorRef& error, const MatrixRef& P) {
  if ((P.diagonal().array() > 0.0).all()) {
    const NeesValue nees = solver_.solve(error, P);
    bool beyond_rounding = nees.dof >= 0;
    for (Index i = 0; beyond_rounding && i < P.rows(); ++i) {
      beyond_rounding = solver_.pivot(i) * solver_.pivot(i) > kLeastPivot * P(i, i);
    }
    if (beyond_rounding) return nees;
  }
  const Matrix full = P.selfadjointView<Eigen::Lower>();
  if (!is_psd(full, kLeastPivot) || !error.allFinite()) return {0.0, -1};
  const Matrix whitening = psd_whitening(full, kLeastPivot);
  return {(whitening * error).squaredNorm(), whitening.rows()};
}

NeesValue SingularNees::solve(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate) {
  find_certain_states(estimate, error, P, certain_);
  if (certain_.empty()) return solve(error, P);
  Vector known_error = error;
  Matrix known_P = P.selfadjointView<Eigen::Lower>();
  make_certain(certain_, known_error, known_P);
  return solve(known_error, known_P);
}

NeesValue SingularNees::judge(const VectorRef& error, const MatrixRef& P, const VectorRef& estimate) {
  const NeesValue nees = solve(error, P, estimate);
  if (nees.dof <= 0 || nees.dof == error.size()) return nees;
  Vector known_error = error;
  Matrix known_P = P.selfadjointView<Eigen::Lower>();
  make_certain(certain_, known_error, known_P);
  return leaves_range(known_error, known_P) ? NeesValue{0.0, 0} : nees;
}

EstimatorRun::EstimatorRun(const OdometryWorld& world, std::unique_ptr<SlamEstimator> filter)
    : world_(world), filter_(std::move(filter)) {
  error_.resize(3 + 2 * world.plane.states());
}

void EstimatorRun::start(const Pose& estimate) {
  filter_->reset(estimate, world_.initial_covariance());
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
