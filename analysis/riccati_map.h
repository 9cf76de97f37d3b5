#pragma once

#include <Eigen/LU>

#include "analysis/riccati_problem.h"

/// @file
/// The filter Riccati equation as a map that is closed under composition (theory: section 3).

namespace credence {

/// The map of 2^k steps, P ↦ c + A (P − c) (I + Γ (P − c))⁻¹ Aᵀ + Θ, around a centre c.
///
/// Around c = 0 this is the classical form. Around a P0 on the trajectory, Θ = P_{2^k} − P0, A is the
/// transition matrix of the filter's error and Γ ≤ P0⁻¹ its information: both stay bounded wherever the
/// filter started from P0 does, also with unstable modes that no noise touches.
/// `Scalar` is double, or float for a first approximation at half the time: what Newton corrections then
/// mend.
template <typename Scalar>
class BasicRiccatiMap {
 public:
  using ScalarMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// One step around zero.
  explicit BasicRiccatiMap(const RiccatiProblem& problem);

  /// One step around `centre`, n×n symmetric psd.
  BasicRiccatiMap(const RiccatiProblem& problem, const Matrix& centre);

  /// Composes the map with itself: twice the steps. 15 n³ operations, 5 n³ while Γ is of low rank.
  ///
  /// Returns false, and leaves the map as it was, when the result is not finite.
  bool square();

  /// Θ of the map that `square` would make, for half the work; not finite when out of range.
  ScalarMatrix next_Theta();

  /// Centre + Θ: the covariance 2^k steps after the centre itself.
  Matrix after_centre() const { return centre_ + Theta_.template cast<double>(); }

  /// The covariance 2^k steps after P. Not finite when the map is used beyond its range.
  Matrix after(const Matrix& P) const;

  const ScalarMatrix& A() const { return A_; }
  const ScalarMatrix& Theta() const { return Theta_; }
  int doublings() const { return doublings_; }

  /// ‖Θ' − Θ‖ / ‖Θ'‖ of the last doubling (Frobenius).
  double last_change() const { return last_change_; }

 private:
  void allocate();
  bool is_factored() const { return 3 * N_.rows() <= A_.rows(); }
  bool square_factored();
  bool square_dense();
  void factorise();
  double add_to_Theta();
  void densify();

  Matrix centre_;
  ScalarMatrix A_, Theta_;
  ScalarMatrix N_, Gamma_;  // Γ = NᵀN while N has few rows, then Gamma_
  bool dense_ = false;
  int doublings_ = 0;
  double last_change_ = 1.0;
  ScalarMatrix W_, X_, product_, next_Gamma_, next_Theta_;
  Eigen::PartialPivLU<ScalarMatrix> lu_;
};

extern template class BasicRiccatiMap<double>;
extern template class BasicRiccatiMap<float>;
using RiccatiMap = BasicRiccatiMap<double>;

}  // namespace credence
