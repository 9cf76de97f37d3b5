#include "analysis/stability/marginal_modes.h"

#include <algorithm>

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

Pairing pair_subspaces(const Matrix& left, const Matrix& right) {
  Pairing pairing{.cosines = dense_svd(left.transpose() * right).s};
  // Beside their own rank cosines have an absolute scale: if all are rounding, none counts.
  pairing.rank = std::min<Index>(decide_rank(pairing.cosines, kPairingTolerance).rank,
                                 (pairing.cosines.array() > kPairingTolerance).count());
  return pairing;
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
