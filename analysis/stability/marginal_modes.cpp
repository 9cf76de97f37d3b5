#include "analysis/stability/marginal_modes.h"

#include "analysis/stability/dense_svd.h"
#include "analysis/stability/invariant_subspace.h"

namespace credence::internal {
namespace {

/// F restricted to the range of orthonormal columns that it maps into themselves.
Matrix restricted(MatrixRef F, const Matrix& basis) { return basis.transpose() * F * basis; }

bool find_undetectable(MatrixRef F, MarginalModes& modes) {
  const Matrix& N = modes.observability.unobservable;
  const InvariantSubspaces unseen(restricted(F, N));
  if (!unseen.ok()) return false;
  modes.unstable_undetectable = unseen.count(UnitCircle::outside);
  modes.undetectable = N * unseen.basis(UnitCircle::on, UnitCircle::outside);
  return true;
}

bool find_untouched(MatrixRef F, MarginalModes& modes) {
  const Matrix& W = modes.noise.uncontrollable;
  const InvariantSubspaces free(restricted(F.transpose(), W));
  if (!free.ok()) return false;
  modes.unstable_uncontrollable = free.count(UnitCircle::outside);
  modes.untouched = W * free.basis(UnitCircle::on);
  return true;
}

}  // namespace

RankDecision pair_subspaces(const Matrix& left, const Matrix& right) {
  // Cosines have an absolute scale: if all are rounding, none counts.
  RankDecision decision = decide_rank(dense_svd(left.transpose() * right).s, kPairingTolerance);
  while (decision.rank > 0 && decision.singular_values[decision.rank - 1] <= kPairingTolerance)
    --decision.rank;
  return decision;
}

MarginalModes marginal_modes(MatrixRef F, MatrixRef H, MatrixRef Qt) {
  MarginalModes modes;
  modes.noise = controllability(F, psd_range(Qt));
  modes.observability = observability(F, H);
  modes.ok = find_undetectable(F, modes) && find_untouched(F, modes);
  if (modes.ok) {
    const Matrix steady = modes.untouched * power_bounded_part(restricted(F.transpose(), modes.untouched));
    modes.pairing = pair_subspaces(steady, modes.undetectable);
  }
  return modes;
}

}  // namespace credence::internal
