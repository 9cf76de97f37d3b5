#pragma once

#include <string>
#include <string_view>

#include "analysis/stability/riccati_doubling.h"

/// @file
/// What the covariance of a filter tends to (theory, section 3).

namespace credence {

/// What the sequence P_k of one P0 does.
enum class RiccatiKind {
  stabilising,  ///< a limit that does not depend on P0; F − F K H has all eigenvalues inside the circle
  strong,       ///< the same with eigenvalues on the unit circle (a static state learnt perfectly)
  depends_on_initial,  ///< a psd limit that depends on P0: marginal modes that nothing observes, or a P0 that
                       ///< leaves out unstable ones
  oscillating,         ///< none, though P stays bounded: it turns for ever with modes on the unit circle that
                       ///< nothing observes
  unbounded,           ///< none: P grows without bound
  undecided,           ///< the instruments disagree or a computation failed; `reason` says how
};

/// "stabilising", "strong", "psd depending on P0", "oscillating", "none", "undecided".
std::string_view to_string(RiccatiKind kind);

/// What is computed beside the limit.
struct RiccatiOptions {
  /// F − F K H is O(n³) more; without them `spectral_radius` is NaN and the vector empty.
  bool closed_loop_eigenvalues = true;
};

/// The limit of the PRIOR covariance, or how it fails to have one.
struct RiccatiSolution {
  RiccatiKind kind = RiccatiKind::undecided;
  std::string reason;     ///< why undecided, else empty
  Matrix P;               ///< the limit of P_{k+1|k}; where there is none, P after `steps` steps
  Matrix K;               ///< filter gain P Hᵀ (H P Hᵀ + R)⁻¹, n×m; the predictor's gain is F K
  double residual = 0.0;  ///< ‖one step from P, minus P‖ / ‖P‖, in balanced units (Frobenius)
  double growth_exponent = 0.0;  ///< g of the last doubling computed: 0 bounded, 1 linear (theory, section 3)
  bool stays_bounded = false;    ///< by prediction and by measurement
  bool exponential = false;      ///< P grows along a mode outside the unit circle that nothing observes
  double steps = 0.0;            ///< how many steps were followed, by doubling
  Eigen::VectorXcd closed_loop_eigenvalues;  ///< of F − F K H, by falling modulus
  double spectral_radius = 0.0;              ///< the largest modulus

  /// P has a limit, which is `P`.
  bool has_limit() const {
    using enum RiccatiKind;
    return kind == stabilising || kind == strong || kind == depends_on_initial;
  }
};

/// Solves the filter Riccati equation in predictor form for the limit that P_k has from P0.
///
/// Regular case (stabilisable, detectable): structured doubling stopped early, then Newton corrections. Else
/// the state space is cut by its modes: what neither P0 nor noise reaches is left out, static functionals
/// that no noise touches and that are learnt perfectly are conditioned on, and the rest is doubled until it
/// stands still; boundedness is both predicted from the modes and measured over 2^21 steps, and a limit is
/// only reported where the two agree. Works for singular Q_t and P0, unstabilisable, undetectable, defective
/// and badly scaled problems: each has a named outcome. O(n³). Throws std::invalid_argument as
/// `require_valid` does.
RiccatiSolution solve_riccati(const internal::RiccatiProblem& problem, const Matrix& P0,
                              const RiccatiOptions& options = {});

/// The same from P0 = I in balanced units: P0 > 0.
RiccatiSolution solve_riccati(const internal::RiccatiProblem& problem, const RiccatiOptions& options = {});

/// Eigenvalues of F − F K H for a filter gain K (not the predictor's), by falling modulus; empty when the
/// iteration does not converge.
Eigen::VectorXcd closed_loop_eigenvalues(MatrixRef F, MatrixRef K, MatrixRef H);

}  // namespace credence
