#pragma once

#include "analysis/stability/riccati.h"

namespace credence::internal {

/// What `solve_riccati` does where doubling alone finds no stabilising solution. The problem is scaled and
/// R = I (riccati_scaling.h). Fills kind, reason, P, residual, growth_exponent, exponential and steps, in
/// the scaled units.
RiccatiSolution solve_marginal_riccati(const RiccatiProblem& problem, const Matrix& P0);

}  // namespace credence::internal
