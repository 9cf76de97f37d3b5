#include "analysis/riccati_map.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/mirror.h"

namespace credence {

template <typename Scalar>
BasicRiccatiMap<Scalar>::BasicRiccatiMap(const RiccatiProblem& problem)
    : A_(problem.F.cast<Scalar>()), Theta_(problem.Qt.cast<Scalar>()), N_(0, problem.state_dim()) {
  const Index n = problem.state_dim();
  centre_ = Matrix::Zero(n, n);
  if (problem.H.rows() > 0) {
    const Eigen::LLT<Matrix> llt(problem.R);
    N_ = Matrix(llt.matrixL().solve(problem.H)).cast<Scalar>();
  }
  allocate();
}

template <typename Scalar>
BasicRiccatiMap<Scalar>::BasicRiccatiMap(const RiccatiProblem& problem, const Matrix& centre)
    : centre_(centre), N_(0, problem.state_dim()) {
  Matrix A = problem.F;
  if (problem.H.rows() > 0) {
    const Matrix PHt = centre * problem.H.transpose();
    const Eigen::LLT<Matrix> llt(problem.H * PHt + problem.R);
    N_ = Matrix(llt.matrixL().solve(problem.H)).cast<Scalar>();
    A -= problem.F * llt.solve(PHt.transpose()).transpose() * problem.H;
  }
  A_ = A.cast<Scalar>();
  Theta_ = Matrix(riccati_step(problem, centre) - centre).cast<Scalar>();
  allocate();
}

template <typename Scalar>
void BasicRiccatiMap<Scalar>::allocate() {
  const Index n = A_.rows();
  for (ScalarMatrix* M : {&W_, &X_, &product_, &next_Gamma_, &next_Theta_}) M->resize(n, n);
  lu_ = Eigen::PartialPivLU<ScalarMatrix>(n);
  if (!is_factored()) densify();
}

template <typename Scalar>
void BasicRiccatiMap<Scalar>::densify() {
  Gamma_ = ScalarMatrix::Zero(A_.rows(), A_.rows());
  Gamma_.template triangularView<Eigen::Lower>() += N_.transpose() * N_;
  mirror_lower(Gamma_);
  dense_ = true;
}

template <typename Scalar>
bool BasicRiccatiMap<Scalar>::square() {
  if (!dense_) return square_factored();
  return square_dense();
}

// With Γ = NᵀN and S = I + N Θ Nᵀ = L Lᵀ: X = (I + ΘΓ)⁻¹ A = A − Θ Nᵀ S⁻¹ N A, and Γ' has the factor
// [N; L⁻¹ N A], of twice the rows. Θ + centre ⪰ 0, but Θ need not be: S is checked.
template <typename Scalar>
bool BasicRiccatiMap<Scalar>::square_factored() {
  const Index n = A_.rows(), r = N_.rows();
  const ScalarMatrix N_Theta = N_ * Theta_;
  ScalarMatrix S = N_Theta * N_.transpose();
  S.diagonal().array() += Scalar(1);
  const Eigen::LLT<ScalarMatrix> llt(S);
  if (llt.info() != Eigen::Success) {
    densify();
    return square_dense();
  }
  const ScalarMatrix E = llt.matrixL().solve(N_Theta);
  ScalarMatrix next_N(2 * r, n);
  next_N.topRows(r) = N_;
  next_N.bottomRows(r) = llt.matrixL().solve(N_ * A_);
  X_ = A_;
  X_.noalias() -= E.transpose() * next_N.bottomRows(r);

  product_.noalias() = A_ * Theta_;
  next_Theta_.setZero();
  next_Theta_.template triangularView<Eigen::Lower>() += product_ * A_.transpose();
  if (r > 0) {
    const ScalarMatrix EA = E * A_.transpose();
    next_Theta_.template triangularView<Eigen::Lower>() -= EA.transpose() * EA;
  }
  const double change = add_to_Theta();
  product_.noalias() = A_ * X_;
  const double size = next_Theta_.norm();
  if (!std::isfinite(size) || !product_.allFinite() || !next_N.allFinite()) return false;
  A_.swap(product_);
  N_.swap(next_N);
  Theta_.swap(next_Theta_);
  last_change_ = size > 0.0 ? change / size : 0.0;
  ++doublings_;
  if (!is_factored()) densify();
  return true;
}

template <typename Scalar>
void BasicRiccatiMap<Scalar>::factorise() {
  W_.noalias() = Theta_ * Gamma_;
  W_.diagonal().array() += Scalar(1);
  lu_.compute(W_);
}

/// Completes next_Theta_, whose lower triangle holds what is added, and returns the size of that.
template <typename Scalar>
double BasicRiccatiMap<Scalar>::add_to_Theta() {
  mirror_lower(next_Theta_);
  const double change = next_Theta_.norm();
  next_Theta_ += Theta_;
  return change;
}

// A' = A X, Γ' = Γ + Aᵀ Γ X, Θ' = Θ + A Θ Y with X = (I + ΘΓ)⁻¹ A and Y = (I + ΓΘ)⁻¹ Aᵀ.
template <typename Scalar>
bool BasicRiccatiMap<Scalar>::square_dense() {
  factorise();
  X_ = lu_.solve(A_);
  product_.noalias() = Gamma_ * X_;
  next_Gamma_ = Gamma_;
  next_Gamma_.template triangularView<Eigen::Lower>() += A_.transpose() * product_;
  mirror_lower(next_Gamma_);

  W_ = lu_.transpose().solve(A_.transpose());
  product_.noalias() = Theta_ * W_;
  next_Theta_.setZero();
  next_Theta_.template triangularView<Eigen::Lower>() += A_ * product_;
  const double change = add_to_Theta();

  product_.noalias() = A_ * X_;
  const double size = next_Theta_.norm();
  if (!std::isfinite(size) || !product_.allFinite() || !next_Gamma_.allFinite()) return false;
  A_.swap(product_);
  Gamma_.swap(next_Gamma_);
  Theta_.swap(next_Theta_);
  last_change_ = size > 0.0 ? change / size : 0.0;
  ++doublings_;
  return true;
}

template <typename Scalar>
auto BasicRiccatiMap<Scalar>::next_Theta() -> ScalarMatrix {
  if (!dense_) densify();
  factorise();
  W_ = lu_.transpose().solve(A_.transpose());
  product_.noalias() = Theta_ * W_;
  next_Theta_.setZero();
  next_Theta_.template triangularView<Eigen::Lower>() += A_ * product_;
  add_to_Theta();
  return next_Theta_;
}

template <typename Scalar>
Matrix BasicRiccatiMap<Scalar>::after(const Matrix& P) const {
  const ScalarMatrix D = (P - centre_).cast<Scalar>();
  ScalarMatrix W = dense_ ? ScalarMatrix(Gamma_ * D) : ScalarMatrix(N_.transpose() * (N_ * D));
  W.diagonal().array() += Scalar(1);
  const Eigen::PartialPivLU<ScalarMatrix> lu(W);
  const ScalarMatrix Y = lu.solve(A_.transpose());
  const ScalarMatrix change = A_ * (D * Y) + Theta_;
  const Matrix result = change.template cast<double>() + centre_;
  return 0.5 * (result + result.transpose());
}

template class BasicRiccatiMap<double>;
template class BasicRiccatiMap<float>;

}  // namespace credence
