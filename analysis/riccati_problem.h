#pragma once

#include "core/types.h"

/// @file
/// The filter Riccati equation of a linear system (theory: section 3).

namespace credence {

/// A filter Riccati problem in predictor form: P is the PRIOR covariance P_{k+1|k} and
///
///   P ← F (P − P Hᵀ (H P Hᵀ + R)⁻¹ H P) Fᵀ + Q_t,   Q_t = G Q Gᵀ + ΔP.
///
/// Shapes: F n×n, H m×n, Qt n×n symmetric psd (may be singular), R m×m symmetric positive definite.
struct RiccatiProblem {
  Matrix F, H, Qt, R;

  Index state_dim() const { return F.rows(); }
};

/// Throws std::invalid_argument, naming the matrix, for shapes that do not match, entries that are not
/// finite, Qt or P0 that are not symmetric psd (beyond rounding), and R that is not positive definite.
void require_valid(const RiccatiProblem& problem, MatrixRef P0);

/// One plain step of the equation above; the independent check of everything else. P n×n psd.
Matrix riccati_step(const RiccatiProblem& problem, MatrixRef P);

}  // namespace credence
