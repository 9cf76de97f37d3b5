#pragma once

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/manifold/chart.h"

namespace credence {

/// What becomes of P as a correction moves the estimate.
enum class CovarianceReset {
  none,  ///< it keeps its numbers, in its chart
  full,  ///< it is carried along
};

/// An extended Kalman filter on a Lie group of dimension n, whose error is Gaussian in a chart of its own:
/// componentwise it is the error-state EKF, in the right chart the left-invariant EKF, in the left chart the
/// right-invariant EKF ([Barrau 2017]).
///
/// A model states its Jacobians once, by right perturbations x Exp(ξ), and P is kept so; T_c(x) is the
/// Jacobian from there to chart c at x. As P_c = T_c P T_cᵀ, F_c = T_c(f(x)) F T_c(x)⁻¹ and H_c = H T_c(x)⁻¹
/// are the filter of chart c, a prediction is the same in all charts. What sets them apart is the update:
/// x̂⁺ = x̂ ⊞ K_c ν by chart c, whose P_c holds at x̂⁺ with the numbers it had at x̂. Unless P is reset: then it
/// is carried from x̂ to x̂⁺ by the Jacobian of the coordinates at the correction, and the right and the left
/// chart, between which all is linear, are the same filter. Nothing allocates but the innovation and its
/// covariance.
template <LieGroup G>
class ChartEkf {
 public:
  using Jacobian = typename G::Jacobian;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, G::kDim>;

  explicit ChartEkf(Chart chart, CovarianceReset reset = CovarianceReset::none)
      : chart_(chart), reset_(reset) {}

  /// Starts at x with the covariance P of an error in chart `of_P`.
  void reset(const G& x, const Jacobian& P, Chart of_P) {
    x_ = x;
    P_ = transported(P, x, of_P, Chart::right);
  }

  /// Time update to f(x̂) = `moved`, where f(x̂ Exp(ξ)) = f(x̂) Exp(F ξ + w) to first order, w ~ N(0, Q).
  void predict(const G& moved, const Jacobian& F, const Jacobian& Q) {
    x_ = moved;
    P_ = (F * P_ * F.transpose() + Q).eval();
    internal::symmetrise(P_);
  }

  /// Measurement update by ν = z − h(x̂), m, where h(x̂ Exp(ξ)) = h(x̂) + H ξ to first order; R is m×m. Joseph's
  /// form. False where S is not positive definite, and nothing has changed but the innovation.
  bool update(const Vector& nu, const Rows& H, const Matrix& R) {
    nu_ = nu;
    S_ = H * P_ * H.transpose() + R;
    const Eigen::LLT<Matrix> factor(S_);
    if (!S_.allFinite() || factor.info() != Eigen::Success) return false;
    const Eigen::Matrix<double, G::kDim, Eigen::Dynamic> K = factor.solve(H * P_).transpose();
    const Jacobian A = Jacobian::Identity() - K * H;
    P_ = (A * P_ * A.transpose() + K * R * K.transpose()).eval();
    const G before = x_;
    const Jacobian T = minus_jacobian(before, before, chart_);
    x_ = plus(before, typename G::Tangent(T * (K * nu)), chart_);
    const G& about = reset_ == CovarianceReset::full ? before : x_;
    const Jacobian M = plus_jacobian(x_, about, chart_) * T;
    P_ = (M * P_ * M.transpose()).eval();
    internal::symmetrise(P_);
    return true;
  }

  Chart chart() const { return chart_; }
  const G& state() const { return x_; }
  /// P of the error in any chart.
  Jacobian covariance(Chart chart) const { return transported(P_, x_, Chart::right, chart); }
  const Vector& innovation() const { return nu_; }            ///< ν of the last update
  const Matrix& innovation_covariance() const { return S_; }  ///< its S

 private:
  Chart chart_;
  CovarianceReset reset_;
  G x_;
  Jacobian P_ = Jacobian::Zero();
  Vector nu_;
  Matrix S_;
};

}  // namespace credence
