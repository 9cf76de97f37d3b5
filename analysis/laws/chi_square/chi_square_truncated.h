#pragma once

#include "analysis/laws/chi_square/chi_square_cumulants.h"

/// @file
/// The law of a NIS that had to pass a gate: χ²(dof) given that it is at most `gate`.
///
/// An innovation accepted by a validation gate is no longer χ²: with 2 dof and the 99 % gate its mean
/// is 1.907 and not 2, so a plain NIS test calls every gated filter pessimistic once enough values are in
/// (theory, section 7). dof and gate must be > 0 (std::invalid_argument); an infinite gate is no gate.

namespace credence::internal {

/// Mean, variance and third cumulant of χ²(dof) given that it is at most `gate`, from
/// E[X^j | X ≤ gate] = dof (dof + 2) … (dof + 2j − 2) F_{dof+2j}(gate) / F_dof(gate).
Cumulants truncated_chi_square_cumulants(double dof, double gate);

}  // namespace credence::internal
