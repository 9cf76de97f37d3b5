#pragma once

#include <vector>

#include "core/types.h"

/// @file
/// Which eigenvalues of F lie inside, on and outside the unit circle, and the subspaces that belong to them.

namespace credence::internal {

enum class UnitCircle { inside, on, outside };

/// Tells inside from on from outside with a tolerance on |λ| of 1e-8.
///
/// A Jordan block of size s scatters its eigenvalue by ε^{1/s} on a circle, which would put a marginal mode
/// on both sides; s eigenvalues that are no further from their mean than that are judged by their mean.
std::vector<UnitCircle> classify_unit_circle(const Eigen::VectorXcd& eigenvalues);

/// The modes of a square real matrix, from its Schur form.
class InvariantSubspaces {
 public:
  /// O(n³). `ok()` is false when the iteration did not converge; nothing else may then be asked.
  explicit InvariantSubspaces(MatrixRef F);

  bool ok() const { return ok_; }
  Index count(UnitCircle where) const;

  /// Orthonormal real basis X, n×count, of the invariant subspace F X = X Λ that belongs to all eigenvalues
  /// (with Jordan chains) in one place, or in two.
  Matrix basis(UnitCircle where) const;
  Matrix basis(UnitCircle where, UnitCircle or_where) const;

 private:
  Matrix basis_of(const std::vector<bool>& selected) const;

  bool ok_ = false;
  Eigen::MatrixXcd T_, U_;
  Eigen::VectorXcd eigenvalues_;
  std::vector<UnitCircle> where_;
};

/// Orthonormal basis Y of the span of all right eigenvectors of Λ, q×q with its spectrum on the unit
/// circle: the part on which powers of Λ stay bounded. It is everything unless Λ has Jordan chains.
Matrix power_bounded_part(MatrixRef Lambda);

}  // namespace credence::internal
