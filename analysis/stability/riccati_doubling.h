#pragma once

#include <vector>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/matrix_product.h"
#include "core/linear_algebra/panel_cholesky.h"
#include "core/types.h"

/// @file
/// The filter Riccati equation as a map that is closed under composition (theory, section 3; [Chu 2004]).

namespace credence::internal {

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

/// The map of 2^k steps, P ↦ c + A (P − c) (I + Γ (P − c))⁻¹ Aᵀ + Θ, around a centre c.
///
/// Around c = 0 this is the classical form. Around a P0 on the trajectory, Θ = P_{2^k} − P0, A is the
/// transition matrix of the filter's error and Γ ≤ P0⁻¹ its information: both stay bounded wherever the
/// filter started from P0 does, also with unstable modes that no noise touches.
class RiccatiMap {
 public:
  /// One step around zero.
  explicit RiccatiMap(const RiccatiProblem& problem);

  /// One step around `centre`, n×n symmetric psd.
  RiccatiMap(const RiccatiProblem& problem, const Matrix& centre);

  /// Composes the map with itself: twice the steps. 14 n³ operations, 5 n³ + 7 n² r + 3 n r² while Γ has a
  /// small rank r, and 15 n³ by an LU factorisation where Γ is singular or A large.
  ///
  /// Returns false, and leaves the map as it was, when the result is not finite.
  bool square();

  /// Θ of the map that `square` would make, for less than half the work; not finite when out of range.
  Matrix next_Theta();

  /// Centre + Θ: the covariance 2^k steps after the centre itself.
  Matrix after_centre() const { return centre_ + Theta_; }

  /// The covariance 2^k steps after P. Not finite when the map is used beyond its range.
  Matrix after(const Matrix& P) const;

  const Matrix& A() const { return A_; }
  const Matrix& Theta() const { return Theta_; }
  int doublings() const { return doublings_; }

  /// ‖Θ' − Θ‖ / ‖Θ'‖ of the last doubling (Frobenius).
  double last_change() const { return last_change_; }

 private:
  enum class Factored { Theta_alone, with_A };
  void allocate();
  void copy_gamma(Matrix& to);
  void factor_gamma();
  ProductFactor C() const;
  void densify();
  bool factorise(Factored what);
  void factorise_dense();
  double combine_Theta();
  double combine_Theta_dense();
  double complete_Theta();
  bool square_factored();
  bool square_dense();
  bool accept(double change);

  Matrix centre_, A_, Theta_;
  Matrix C_, Gamma_;    // Γ = C Cᵀ, C of few columns and Gamma_ empty, or C the Cholesky factor of Gamma_
  bool dense_ = false;  // Γ or I + CᵀΘC has no Cholesky factor: there is Gamma_ alone
  int doublings_ = 0;
  double last_change_ = 1.0;
  Matrix S_, Y_, W_, X_, Z_, product_, next_Gamma_, next_Theta_;
  PanelCholesky cholesky_;
  Eigen::PartialPivLU<Matrix> lu_;
  MatrixProduct multiply_;
};

/// tr P_{2^k} for k = 0, 1, …, from P0.
struct RiccatiGrowth {
  /// Of P after 2^k steps; ends early when the next would not be finite, or where rounding began to show.
  std::vector<double> traces;
  bool overflowed = false;  ///< the covariance left 1e100, or the range of double
  Matrix P;                 ///< after 2^(traces.size() − 1) steps
  Matrix P_before;          ///< after half as many

  /// The number of steps that P stands for.
  double steps() const;

  /// g = log2(tr P_{2^{k+1}} / tr P_{2^k}) of the last doubling: 0 bounded, 1 linear growth; 0 for P = 0.
  double exponent() const;

  /// h = log2 of the ratio of the last two increments of the trace: 1 linear growth, however slow, −1 an
  /// approach as 1/k. 0 where the increments are not both above 1e-5 of the trace.
  double increment_exponent() const;

  /// The last increment of the trace, per step.
  double trace_per_step() const;

  /// The trace grows: by its size (g > 1/2), or steadily by its increments (h > 1/2 twice). A growth of less
  /// than about 1e-11 of the trace per step is not seen after 2^21 steps.
  bool grows() const;
};

/// Whether to watch for rounding.
enum class GrowthGuard {
  none,
  two_maps,  ///< follow P around two centres and stop where they disagree by 10⁻³; twice the time
};

/// Follows P from P0 through 2^doublings steps (theory, section 3). Never throws for a valid problem.
RiccatiGrowth riccati_growth(const RiccatiProblem& problem, const Matrix& P0, int doublings = 21,
                             GrowthGuard guard = GrowthGuard::two_maps);

}  // namespace credence::internal
