#pragma once

#include <span>

#include "core/types.h"

/// @file
/// Controllability and observability ranks, each with the singular values that it was decided on.
///
/// The Kalman matrices [B | F B | …] and [H; H F; …] are never formed: their columns fall off or grow like
/// powers of F until a rank is no longer visible. Instead the subspace grows by one block of orthonormal
/// directions at a time (a staircase), and each new block is an SVD of entries of order one.
/// Rows and columns are scaled by powers of two (by no more than 2^14), so that the integers do not
/// depend on the units of the states. Shapes: F n×n, B n×q, H m×n; std::invalid_argument else, and for
/// entries that are not finite.

namespace credence {

/// A singular value counts when it exceeds this share of the largest.
inline constexpr double kRankTolerance = 1e-9;

/// The same for eigenvalues of a scaled covariance, whose entries carry more rounding.
inline constexpr double kPsdRankTolerance = 1e-8;

/// Of more states a staircase in doubt is not examined mode by mode, which costs O(n⁴).
inline constexpr Index kMostExaminedStates = 64;

/// An integer rank and how safe it is.
struct RankDecision {
  Index rank = 0;
  Vector singular_values;  ///< falling, scaled so that the largest is of order one; may be empty for rank 0
  double gap = 0.0;        ///< last counted over first not counted; ∞ when nothing non-zero was left out
  bool doubtful = false;   ///< some that count may be rounding alone: then the rank is less
};

/// Counts the values above tolerance · largest. `values` need not be sorted.
RankDecision decide_rank(const Vector& values, double tolerance = kRankTolerance);

/// Rank of a symmetric positive semidefinite matrix such as ΔP or Q_t, by the eigenvalues after scaling to
/// unit diagonal (no state by more than 10^3), so that it does not depend on units.
///
/// Negative eigenvalues count as their modulus: they are then visible in the singular values.
RankDecision psd_rank(MatrixRef M, double tolerance = kPsdRankTolerance);

/// An orthonormal basis of the range of a symmetric positive semidefinite matrix, decided as in `psd_rank`.
Matrix psd_range(MatrixRef M, double tolerance = kPsdRankTolerance);
/// Likewise of the null space.
Matrix psd_null_space(MatrixRef M, double tolerance = kPsdRankTolerance);

/// The reachable part of (F, B).
struct Controllability {
  RankDecision decision;
  Matrix controllable;    ///< n×rank, orthonormal: the range of [B | F B | …]
  Matrix uncontrollable;  ///< n×(n − rank), orthonormal columns w: wᵀ F^k B = 0 for all k
};

/// Controllability of the noise that enters through B: B = G Q^{1/2} or any matrix of the same range, such
/// as Q_t itself (theory, section 3). O(n³).
Controllability controllability(MatrixRef F, MatrixRef B);

/// The same for B = G Q^{1/2}, Q symmetric positive semidefinite.
Controllability controllability(MatrixRef F, MatrixRef G, MatrixRef Q);

/// The observable part of (F, H).
struct ObservabilityAnalysis {
  RankDecision decision;
  Matrix unobservable;  ///< n×(n − rank), orthonormal: the directions d with H F^k d = 0 for all k
};

/// Observability of a time-invariant linear model. O(n³).
ObservabilityAnalysis observability(MatrixRef F, MatrixRef H);

/// Local observability along a trajectory: the null space of the stack of H_k Φ_k, Φ_0 = I,
/// Φ_{k+1} = F_k Φ_k (theory, section 5, planar table).
///
/// `H` may have one entry more than `F` or as many; a step that saw nothing has an H_k of no rows. The
/// unobservable directions are those of the state at k = 0; Φ_k d at step k. O(steps · n³).
ObservabilityAnalysis local_observability(std::span<const Matrix> F, std::span<const Matrix> H);

}  // namespace credence
