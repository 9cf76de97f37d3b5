#pragma once

#include "analysis/stability/ranks.h"
#include "core/types.h"

/// @file
/// The modes on and outside the unit circle that no measurement sees or no noise touches: they decide
/// whether P stays bounded and what it tends to (theory, sections 3 and 5).

namespace credence::internal {

/// A cosine between two subspaces above which they count as not orthogonal.
inline constexpr double kPairingTolerance = 1e-7;

/// How two subspaces lie to each other.
struct Pairing {
  Index rank = 0;    ///< of leftᵀ · right
  Vector cosines{};  ///< of the angles between them, the largest first
};

/// What there is of such modes in (F, H, Q_t), and how they pair.
struct MarginalModes {
  bool ok = false;  ///< false: the eigenvalues did not converge, nothing else is set

  Controllability noise;                ///< of (F, Q_t)
  ObservabilityAnalysis observability;  ///< of (F, H)

  Matrix undetectable;              ///< n×p, orthonormal: invariant, unobservable, |λ| ≥ 1
  Index unstable_undetectable = 0;  ///< how many of those have |λ| > 1

  Matrix untouched;                   ///< n×q, orthonormal columns t: left-invariant, t Q_t = 0, |λ| = 1
  Index unstable_uncontrollable = 0;  ///< left modes with t Q_t = 0 and |λ| > 1

  /// Of Tᵀ · undetectable, by cosines of the angles between them; T, n×q', is the part of `untouched` that
  /// stays bounded in time: no Jordan chains.
  Pairing pairing;

  /// Z Nᵒ has full column rank: some functional that no noise touches fixes every undetectable direction.
  bool paired() const { return unstable_undetectable == 0 && pairing.rank == undetectable.cols(); }
};

/// Finds them by staircases and Schur forms. O(n³). Shapes as in RiccatiProblem; for best numbers the
/// states should be scaled. The tolerances are kRankTolerance, kPsdRankTolerance (for Qt) and those of
/// classify_unit_circle.
MarginalModes marginal_modes(MatrixRef F, MatrixRef H, MatrixRef Qt);

/// Rank of leftᵀ · right for orthonormal columns, by the cosines of the angles between their spans.
Pairing pair_subspaces(const Matrix& left, const Matrix& right);

}  // namespace credence::internal
