#include "montecarlo/worlds/planar/planar_normaliser.h"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra/cholesky.h"
#include "core/record/piece_covariances.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence::internal {
namespace {

/// eᵀ P⁻¹ e of the two states from i on.
double pair_nees(const Vector& error, const Matrix& P, Index i) {
  const double ratio = P(i + 1, i) / P(i, i), rest = P(i + 1, i + 1) - ratio * P(i + 1, i);
  const double v = error[i + 1] - ratio * error[i];
  return error[i] * error[i] / P(i, i) + v * v / rest;
}

}  // namespace

bool PlanarNormaliser::normalise_state(const Vector& estimate, const Vector& error, const Matrix& P,
                                       const NeesSolver& factor, std::span<const int> landmarks,
                                       NormalisedStep& told) const {
  const Vector& u = factor.whitened();
  const double nees = u.squaredNorm();
  if (!factor.well_conditioned(P) || !std::isfinite(nees)) return false;
  const JointNormalised joint{.whole = {nees, u.size()},
                              .log_determinant = factor.log_determinant(),
                              .map_nees = landmarks.empty() ? 0.0 : factor.without_lead()};
  return normalise_state(estimate, error, P, joint, landmarks, told);
}

bool PlanarNormaliser::normalise_state(const Vector& estimate, const Vector& error, const Matrix& P,
                                       const JointNormalised& joint, std::span<const int> landmarks,
                                       NormalisedStep& told) const {
  const Eigen::Matrix3d P_rr = P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
  const Eigen::LLT<Eigen::Matrix3d> root(P_rr);
  if (root.info() != Eigen::Success) return false;
  const Eigen::Vector3d u = root.matrixL().solve(error.head<3>());
  slam_states({.vehicle = 3, .landmark = 2, .landmarks = world_.states()}, landmarks, told.states);
  told.estimate = estimate;
  told.error = error;
  told.variance = P.diagonal();
  if (joint.tells_covariance && P.rows() <= kLargestTold) {
    told.P = P;
  } else {
    told.P.resize(0, 0);
  }
  told.whole = {joint.whole.value, joint.whole.dof};
  told.log_determinant = joint.log_determinant;
  told.lead.error = error.head<3>();
  told.lead.P = P_rr;
  told.position.error = error.head<2>();
  told.position.P = P_rr.topLeftCorner<2, 2>();

  const Index singles = std::min(world_.states(), kSingleLandmarks);
  told.blocks.assign(static_cast<std::size_t>(3 + singles + (world_.states() > 0 ? 1 : 0)), {});
  told.blocks[0] = {u.squaredNorm(), 3};
  told.blocks[1] = {u.head<2>().squaredNorm(), 2};
  const double heading = error[2] / std::sqrt(P(2, 2));
  told.blocks[2] = {heading * heading, 1};
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (landmarks[i] >= singles) continue;
    told.blocks[3 + static_cast<std::size_t>(landmarks[i])] = {
        pair_nees(error, P, 3 + 2 * static_cast<Index>(i)), 2};
  }
  if (!landmarks.empty()) told.blocks.back() = {joint.map_nees, joint.whole.dof - 3};

  const auto place_of = [&](Index landmark) {
    return std::ranges::find(landmarks, static_cast<int>(landmark));
  };
  const Index chosen =
      landmark_in_turn(told.step, singles, [&](Index l) { return place_of(l) != landmarks.end(); });
  told.moving.places.clear();
  if (world_.states() == 0) told.moving = {told.position, {0, 1}};
  if (chosen < 0) return true;
  const Index i = 3 + 2 * static_cast<Index>(place_of(chosen) - landmarks.begin());
  told.moving.places = {0, 1, 2, i, i + 1};
  told.moving.error = error(told.moving.places);
  told.moving.P.resize(5, 5);
  for (Index a = 0; a < 5; ++a) {
    for (Index b = 0; b < 5; ++b) {
      const auto [column, row] = std::minmax(told.moving.places[static_cast<std::size_t>(a)],
                                             told.moving.places[static_cast<std::size_t>(b)]);
      told.moving.P(a, b) = P(row, column);
    }
  }
  return true;
}

bool PlanarNormaliser::normalise_innovation(const VectorRef& nu, const MatrixRef& S, NormalisedStep& told) {
  told.innovations.resize(1);
  NormalisedInnovation& innovation = told.innovations.front();
  innovation.dof = -1;
  if (nu.size() == 0) return true;
  const NeesValue nis = solver_.solve(nu, S);
  if (nis.dof != nu.size() || !std::isfinite(nis.value) || !solver_.well_conditioned(S)) return false;
  innovation.value = nis.value;
  innovation.dof = nis.dof;
  innovation.whitened = solver_.whitened();
  innovation.nu = nu;
  innovation.variance = S.diagonal();
  take_piece_covariances(S, 2, innovation.covariance);
  innovation.noise_share = variances_.empty() ? kNaN : solver_.noise_share(variances_);
  return true;
}

}  // namespace credence::internal
