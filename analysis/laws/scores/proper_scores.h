#pragma once

#include "core/types.h"

/// @file
/// Proper scores of one step: how good the claimed law N(0, P) of an error e is, with what it would score on
/// average if it were true.
///
/// NEES asks whether P is right; a score asks which of two filters is better, and rewards a P that is right
/// and small: a proper score is best on average for the law the errors really have (T. Gneiting, A. E.
/// Raftery, "Strictly proper scoring rules, prediction, and estimation", J. Am. Stat. Assoc. 102, 2007).
/// Average both numbers over steps and runs; the runs are the units of any interval (hall_score.h), as steps
/// are correlated.

namespace credence::internal {

/// A score and its mean under the claimed law.
struct Score {
  double value = 0.0;
  double expected = 0.0;
};

/// The logarithmic score, ln of the density of e under N(0, P), higher is better,
///
///   −½ (n ln 2π + ln det P + ε),  expected −½ (n ln 2π + ln det P + n),  ε = eᵀ P⁻¹ e.
///
/// value − expected = (n − ε)/2: of calibration it says what NEES says. For a P of rank n, its
/// pseudo-determinant. Throws std::invalid_argument unless nees ≥ 0 or NaN and dof ≥ 0.
Score log_score(double nees, double log_determinant, double dof);

/// The energy score, in the unit of e, lower is better, X, X' ~ N(0, P):
///
///   E|e − X| − ½ E|X − X'|,  expected ½ E|X − X'|,
///
/// for one component the CRPS. All components must share a unit: a position, or headings, not both. The means
/// of √q, q = |e − X|², are found from the Laplace transform of the noncentral χ² form q,
///
///   E√q = (2√π)⁻¹ ∫₀^∞ (1 − φ(t)) t^{−3/2} dt,  φ(t) = Π_j (1 + 2 λ_j t)^{−1/2} exp(−t d_j²/(1 + 2 λ_j t)),
///
/// λ_j the eigenvalues of P and d_j the components of e along its eigenvectors, by the trapezoidal rule in
/// ln t after 1 − 1/(1 + t) is taken off: about 1e-13 relative. Cost one eigenvalue decomposition and 400 n
/// operations. A P of zero variances is legal. NaN for an error or a P that is not finite or has an
/// eigenvalue below −1e-9 of the largest. Throws std::invalid_argument for sizes that differ.
Score energy_score(VectorRef error, MatrixRef P);

/// The energy score of the whitened error u = L⁻¹ e, P = L Lᵀ, under N(0, I_n), which depends on NEES |u|²
/// alone and so has no unit and suits a state of mixed ones:
///
///   E|u − Z| = √2 Γ((n + 1)/2)/Γ(n/2) ₁F₁(−½; n/2; −|u|²/2),  ½ E|Z − Z'| = Γ((n + 1)/2)/Γ(n/2).
///
/// computed by the integral of energy_score, as ₁F₁ of Boost 1.74 fails for some large n. It grows as √NEES
/// and not as NEES: less moved by outliers than the logarithmic score. NaN for a NaN; throws
/// std::invalid_argument unless nees ≥ 0 and dof > 0 is finite.
Score whitened_energy_score(double nees, double dof);

}  // namespace credence::internal
