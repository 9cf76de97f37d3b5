#pragma once

#include "analysis/stability/ranks.h"
#include "analysis/stability/riccati_doubling.h"

/// @file
/// The condition on a constant noise under which the covariance of stationary states stays bounded, with the
/// bound, or with the rate at which it grows.

namespace credence {

/// P between two explicit bounds for ever: F = I and constant Q_t, H and R ≻ 0 (theory, section 5, Theorem
/// 1).
///
/// With M = Q_t Hᵀ (H Q_t Hᵀ)⁺ in units in which R = I, and Ψ = I − M H, the covariance P_k after k steps
/// (predict, update) obeys
///
///   k S ⪯ P_k ⪯ k S + B,   S = Ψ Q_t Ψᵀ,   B = Ψ P0 Ψᵀ + M R Mᵀ,
///
/// S being the part of the noise that no measurement ever sees. P is bounded for every P0 iff S = 0, which is
/// ker H ∩ range Q_t = {0}.
struct NoiseCondition {
  RankDecision noise;  ///< rank of Q_t
  RankDecision seen;   ///< rank of H on the range of Q_t; bounded iff it is that of Q_t
  Matrix S;            ///< n×n, what P grows by per step; exactly 0 where bounded
  Matrix B;            ///< n×n
  Vector direction;    ///< u, unit: the eigenvector of S of the largest eigenvalue; empty where bounded
  double rate = 0.0;   ///< c = 1/(uᵀ Q_t⁺ u), that eigenvalue: P_k ⪰ k c u uᵀ; 0 where bounded

  bool bounded() const { return direction.size() == 0; }
  double growth_per_step() const { return S.trace(); }  ///< tr P_k / k tends to it
  double trace_bound() const { return B.trace(); }      ///< tr P_k ≤ k tr S + this, k ≥ 1
};

/// The condition for `problem`, whose F must be the identity, with P = P0 at the beginning.
///
/// Ranks are decided with kPsdRankTolerance for Q_t, which the range below it is left out of, and with
/// kRankTolerance for H on that range. Throws std::invalid_argument for an F that is not the identity and for
/// what `require_valid` refuses. O(n³).
NoiseCondition noise_condition(const internal::RiccatiProblem& problem, MatrixRef P0);

}  // namespace credence
