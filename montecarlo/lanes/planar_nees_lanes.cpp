#include "montecarlo/lanes/planar_nees_lanes.h"

#include <algorithm>
#include <cmath>

#include "core/filters/nees_along_run.h"
#include "core/linear_algebra/logarithm.h"
#include "core/simd/kernel_choice.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence::internal {

const PlanarNeesKernel& planar_nees_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(planar_nees_kernel));
}

PlanarNeesLanes::PlanarNeesLanes(Index states, Index measured, InstructionSet set)
    : kernel_(planar_nees_kernel(set)),
      states_(states),
      Sigma_(6),
      A_(at(3 * states)),
      w_(at(states)),
      map_error_(at(states)),
      tells_(at(2 * measured)),
      scalars_(at(2 * measured)),
      determinants_(at(states / 2)),
      vehicle_white_(3) {}

void PlanarNeesLanes::reset(int lane, const Eigen::Matrix3d& P) {
  for (Lanes& a : A_) a[lane] = 0.0;
  for (Lanes& w : w_) w[lane] = 0.0;
  for (Lanes& e : map_error_) e[lane] = 0.0;
  for (Index r = 0, i = 0; r < 3; ++r) {
    for (Index c = 0; c <= r; ++c, ++i) Sigma_[at(i)][lane] = P(r, c);
  }
  map_log_determinant_[lane] = 0.0;
  trusted_ = with(trusted_, lane);
  valued_ = without(valued_, lane);
}

void PlanarNeesLanes::distrust(int lane) {
  trusted_ = without(trusted_, lane);
  valued_ = without(valued_, lane);
}

PlanarNeesData PlanarNeesLanes::kernel_data(const LaneNumbers& error, const double* prior) {
  return {.states = states_,
          .Sigma = data(Sigma_),
          .A = data(A_),
          .w = data(w_),
          .error = data(error),
          .prior = prior,
          .tells = data(tells_),
          .scalars = data(scalars_),
          .nees = nees_.of,
          .map_nees = map_nees_.of,
          .inverse_root = inverse_root_.of,
          .doubt = doubt_.of,
          .trace = trace_.of,
          .dof = dof_.of,
          .map_error = squared_map_error_.of,
          .largest = largest_.of,
          .finite = finite_.of,
          .vehicle_nees = vehicle_nees_.of,
          .vehicle_white = data(vehicle_white_)};
}

void PlanarNeesLanes::move(const double* F, const double* GQG) {
  kernel_.move(kernel_data(map_error_), F, GQG);
}

void PlanarNeesLanes::start(const PlanarLanesData& filter) {
  kernel_.start(kernel_data(map_error_), filter, data(determinants_));
  if (states_ == 3) return;
  for (int lane = 0; lane < kPlanarLanes; ++lane) {
    map_log_determinant_[lane] = log_of_product(&determinants_[0].of[lane], (states_ - 3) / 2, kPlanarLanes);
  }
}

void PlanarNeesLanes::correct(const PlanarLanesData& filter, const LaneNumbers& prior, bool logarithms) {
  if (filter.measured == 0) return;
  kernel_.correct(kernel_data(map_error_, data(prior)), filter);
  if (!logarithms) return;
  const Index m = 2 * filter.measured, rows = m + filter.padded + 1;
  for (int lane = 0; lane < kPlanarLanes; ++lane) {
    map_log_determinant_[lane] += log_of_product(&scalars_[0].of[lane], m, kPlanarLanes) +
                                  2.0 * log_of_product(filter.A + lane, m, kPlanarLanes * (rows + 1));
  }
}

// A landmark l = g(x, z) measures 0 = J_r e_r − e_l with the noise J_z R J_zᵀ; as NeesAlongRun::append.
void PlanarNeesLanes::append(int lane, Index state, const Eigen::Matrix<double, 2, 3>& J_r,
                             const Eigen::Matrix2d& noise, const LaneNumbers& error,
                             std::span<const LaneSet> known) {
  const auto triple = [lane](const LaneNumbers& numbers, Index first) -> Eigen::Vector3d {
    return {numbers[at(first)][lane], numbers[at(first + 1)][lane], numbers[at(first + 2)][lane]};
  };
  const Eigen::Vector3d pose = triple(error, 0);
  PoseGivenMap<3> given{.Sigma = {}, .q = pose};
  for (Index r = 0, i = 0; r < 3; ++r) {
    for (Index c = 0; c <= r; ++c, ++i) given.Sigma(r, c) = given.Sigma(c, r) = Sigma_[at(i)][lane];
  }
  const Eigen::Vector2d landmark(error[at(state)][lane], error[at(state + 1)][lane]);
  const auto is_known = [&](Index i) { return has(known[at((i - 3) / 2)], lane); };
  for (Index i = 3; i < states_; ++i) {
    if (is_known(i)) given.q += triple(A_, 3 * i) * error[at(i)][lane];
  }
  // White: L⁻¹ of the noise, L by hand as it is two by two.
  const double a = std::sqrt(noise(0, 0)), b = noise(1, 0) / a, c = std::sqrt(noise(1, 1) - b * b);
  Eigen::Matrix2d whitener;
  whitener << 1.0 / a, 0.0, -b / (a * c), 1.0 / c;
  const Eigen::Matrix<double, 2, 3> H = whitener * J_r;
  const Eigen::Vector2d tells = whitener * (J_r * pose - landmark);
  double scale = 1.0;
  for (Index i = 0; i < 2; ++i) scale *= given.add(H.row(i), tells[i]);
  for (Index i = 3; i < states_; ++i) {
    if (!is_known(i)) continue;
    const Eigen::Vector3d row = triple(A_, 3 * i), corrected = given.C.transpose() * row;
    w_[at(i)][lane] += row.dot(given.t);
    for (Index k = 0; k < 3; ++k) A_[at(3 * i + k)][lane] = corrected[k];
  }
  const Eigen::Vector2d told = -whitener.transpose() * (tells - H * given.q);
  const Eigen::Matrix<double, 3, 2> shared = -given.Sigma * H.transpose() * whitener;
  for (Index l = 0; l < 2; ++l) {
    w_[at(state + l)][lane] = told[l];
    for (Index k = 0; k < 3; ++k) A_[at(3 * (state + l) + k)][lane] = shared(k, l);
  }
  for (Index r = 0, i = 0; r < 3; ++r) {
    for (Index k = 0; k <= r; ++k, ++i) Sigma_[at(i)][lane] = given.Sigma(r, k);
  }
  map_log_determinant_[lane] += natural_logarithm(scale * noise.determinant());
}

void PlanarNeesLanes::judge(const PlanarLanesData& filter, const LaneNumbers& error) {
  std::copy_n(error.begin(), states_, map_error_.begin());
  kernel_.judge(kernel_data(map_error_), filter);
  valued_ = 0;
  for (int lane = 0; lane < kPlanarLanes; ++lane) {
    const bool regular = doubt_[lane] * NeesSolver::least_pivot(states_) < 1.0;
    if (has(trusted_, lane) && regular && std::isfinite(nees_[lane])) valued_ = with(valued_, lane);
  }
}

Eigen::Vector3d PlanarNeesLanes::vehicle_whitened(int lane) const {
  return {vehicle_white_[0][lane], vehicle_white_[1][lane], vehicle_white_[2][lane]};
}

double PlanarNeesLanes::log_determinant(int lane) const {
  return map_log_determinant_[lane] - 2.0 * natural_logarithm(inverse_root_[lane]);
}

}  // namespace credence::internal
