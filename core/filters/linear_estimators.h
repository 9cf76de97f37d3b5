#pragma once

#include <span>
#include <vector>

#include "core/filters/linear_filter.h"

/// @file
/// What may estimate a linear system beside the Kalman filter: filters whose gain is another one, and the
/// smoother. None of them depends on data, so each is computed once for all runs.

namespace credence::internal {

/// A filter with one gain at all steps, x̂ = x̂⁻ + K ν, and P by Joseph's form, which is the covariance of its
/// error whatever the gain. K is n×m. A step that is not finite, or whose S is not positive definite, ends
/// it.
std::vector<LinearFilterStep> constant_gain_steps(const LinearModel& assumed, const Matrix& K, Index steps);

/// The Schmidt filter ([Schmidt 1966]): the gain of the Kalman filter for its own P, with zero rows for the
/// states `considered`; P by Joseph's form.
std::vector<LinearFilterStep> consider_steps(const LinearModel& assumed, std::span<const Index> considered,
                                             Index steps);

/// The gain to which the Kalman filter settles from P0. Throws std::invalid_argument where it does not settle
/// to 1e-13 of itself within 100,000 steps, or has no positive definite S.
Matrix steady_state_gain(const LinearModel& assumed);

/// The smoother of Rauch, Tung and Striebel ([Rauch 1965]) over the steps 0 … T of a Kalman filter, in place:
///
///   C_k = P_k Fᵀ (P⁻_{k+1})⁻¹,   x̂ˢ_k = x̂_k + C_k (x̂ˢ_{k+1} − F x̂_k),   Pˢ_k = P_k + C_k (Pˢ_{k+1} −
///   P⁻_{k+1}) C_kᵀ.
///
/// Where P⁻ is singular its inverse is that over the directions that have a variance.
class RtsSmoother {
 public:
  /// `steps` are those of linear_filter_steps without inflation.
  RtsSmoother(const LinearModel& assumed, std::span<const LinearFilterStep> steps);

  /// x̂_0 … x̂_T of the filter become those of the smoother.
  void smooth(std::span<Vector> estimates) const;
  const Matrix& covariance(std::size_t k) const { return P_[k]; }  ///< Pˢ_k, k = 0 … T

 private:
  Matrix F_;
  std::vector<Matrix> C_, P_;
};

}  // namespace credence::internal
