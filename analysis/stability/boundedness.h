#pragma once

#include <string_view>

#include "analysis/stability/marginal_modes.h"
#include "analysis/stability/ranks.h"
#include "analysis/stability/riccati_doubling.h"

/// @file
/// Does a covariance with inflation stay bounded? What the exact condition says, what the paper's eq. (22)
/// says, and what is measured (theory, section 5). P0 > 0 throughout.

namespace credence::internal {

/// Why an exact condition came out as it did.
enum class BoundednessReason {
  paired,              ///< bounded: functionals that no noise touches fix every unobservable direction
  nothing_unobserved,  ///< bounded: no direction with |λ| ≥ 1 is unobservable
  unpaired,            ///< unbounded: a random walk, or a sum of what stays, that nobody measures
  unstable,            ///< unbounded: an unobservable direction with |λ| > 1
  undecided,           ///< eigenvalues did not converge, or a transition matrix was singular
};

/// "paired", "nothing unobserved", …
std::string_view to_string(BoundednessReason reason);

/// The exact condition with the numbers that it was decided on.
struct ExactBoundedness {
  BoundednessReason reason = BoundednessReason::undecided;
  RankDecision noise;          ///< rank of Q_t, or of the accumulated noise S
  RankDecision observability;  ///< rank O; its kernel is N_o
  Index unobserved = 0;        ///< dimension of N_o, for general F of its part with |λ| ≥ 1
  Pairing pairing;             ///< rank of Zᵀ N_o by the cosines between the two subspaces

  bool bounded() const {
    return reason == BoundednessReason::paired || reason == BoundednessReason::nothing_unobserved;
  }
};

/// P stays bounded iff Zᵀ N_o has full column rank, Z = ker Q_t, N_o = ker O (exact for F = I).
///
/// For another F the same on the modes with |λ| ≥ 1: N_o is then the unobservable subspace of those, and Z
/// the left eigenvectors on the unit circle that no noise touches; an unobservable |λ| > 1 is unbounded.
/// Compare with `measure_boundedness`. O(n³).
ExactBoundedness exact_boundedness(MatrixRef F, MatrixRef H, MatrixRef Qt);

/// The paper's eq. (22), rank ΔP ≤ rank O: necessary in a weaker form only, and not sufficient.
struct PaperBoundedness {
  Index inflation_rank = 0;
  Index observability_rank = 0;

  bool bounded() const { return inflation_rank <= observability_rank; }
};

/// Eq. (22) for a constant ΔP and rank O as decided by `exact_boundedness` or `observability`.
PaperBoundedness paper_boundedness(MatrixRef inflation, Index observability_rank);

/// Noise summed in coordinates of the first step, where unobservable directions are constant:
/// S = Σ Φ_{k+1}⁻¹ (G Q Gᵀ + ΔP)_k Φ_{k+1}⁻ᵀ, Φ_{k+1} = F_k Φ_k.
class AccumulatedNoise {
 public:
  explicit AccumulatedNoise(Index state_dim);

  /// Adds the noise of step k, which enters after its transition F_k. Shapes n×n, Qt_k symmetric psd;
  /// std::invalid_argument else.
  void add(MatrixRef F_k, MatrixRef Qt_k);

  const Matrix& S() const { return S_; }
  bool ok() const { return ok_; }  ///< false after an F_k that was singular to working precision

 private:
  Matrix Phi_, S_;
  bool ok_ = true;
};

/// The condition for ΔP_k that vary along a run: the functionals that no noise touches, Z = ker S, pair
/// non-singularly with the unobservable directions at the first step.
///
/// Exact for H_k and Q_k that are periodic in these coordinates, S being the sum over a period (theory,
/// section 5, Theorem 2). Noise that dies out may leave P bounded whatever S says.
///
/// `psd_tolerance` must be above the accuracy of the ΔP_k: an exact minimal trace that has not converged
/// fills the kernel of S.
ExactBoundedness exact_boundedness(const AccumulatedNoise& noise, const ObservabilityAnalysis& observability,
                                   double psd_tolerance);

/// How P grew, by doubling.
struct MeasuredBoundedness {
  bool bounded = false;
  double growth_exponent = 0.0;  ///< g: 0 bounded, 1 linear (F = I); larger with unobserved drift
  double trace_per_step = 0.0;   ///< growth of tr P per step over the last doubling
  double steps = 0.0;            ///< that were followed; fewer than asked for where rounding began to show
};

/// Follows P from P0 through up to 2²¹ steps: bounded unless `RiccatiGrowth::grows`.
MeasuredBoundedness measure_boundedness(const RiccatiProblem& problem, const Matrix& P0);

}  // namespace credence::internal
