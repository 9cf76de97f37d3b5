#pragma once

#include "analysis/stability/riccati_doubling.h"

/// @file
/// The last digits of a stabilising Riccati solution (theory, section 3, "accuracy, regular case").

namespace credence::internal {

/// The fixed-point error of a P, and what the filter with this P does.
struct RiccatiResidual {
  Matrix closed_loop;   ///< F − F K H
  Matrix defect;        ///< one step from P, minus P
  double relative = 0;  ///< ‖defect‖ / ‖P‖ (Frobenius), or ‖defect‖ / ‖Qt‖ for P = 0
};

/// About 3 n³ operations and n² for each measurement. P symmetric psd, n×n.
RiccatiResidual riccati_residual(const RiccatiProblem& problem, const Matrix& P);

/// Improves P by Newton corrections, P += X with X = A X Aᵀ + defect, A = F − F K H, the Stein equation by
/// Smith doubling [Smith 1968].
///
/// Stops at a residual of `target`, or when a step brings no more, and keeps the best P. Returns false, with
/// P as good as it got, when A is not stable or the residual stays above 1e-8: there is then no certificate
/// that P is the stabilising solution. `residual` is that of the P returned.
bool newton_refine(const RiccatiProblem& problem, Matrix& P, RiccatiResidual& residual,
                   double target = 5e-15);

}  // namespace credence::internal
