#pragma once

#include <string_view>

#include "core/types.h"

namespace credence::internal {

/// A normalised squared error eᵀ P⁻¹ e with the degrees of freedom that P really has.
struct NormalisedError {
  bool ok = false;  ///< false: see reason, the value is not to be used
  std::string_view reason = {};
  double value = 0.0;  ///< infinite if the error leaves the range of P: P claims a certainty that is wrong
  Index dof = 0;       ///< rank of P
  Vector whitened;     ///< dof values, independent N(0, 1) under consistency; value is their squared norm
};

/// eᵀ P⁺ e over the range of P, with its dof (theory, section 7, "rank-aware").
///
/// P is judged in correlation form D^{-1/2} P D^{-1/2}, so that units do not matter. A state counts as known
/// when its variance is 0; further rank is lost when an eigenvalue of the correlation is below 4 n ε of the
/// largest. For full rank `whitened` is L⁻¹ e with P = L Lᵀ, else the components along the eigenvectors. Not
/// ok: P not finite or not positive semidefinite, by an eigenvalue below −10⁻¹² of the largest, which no
/// rounding of a filter makes; or an error that is not finite. Throws std::invalid_argument for sizes that
/// differ. Cost n³/6 at full rank. Serves NEES and NIS alike.
NormalisedError normalised_error(VectorRef error, MatrixRef P);

}  // namespace credence::internal
