#include "core/record/nees_solver.h"

#include <cmath>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/logarithm.h"
#include "core/nan.h"

namespace credence {

using namespace internal;

bool NeesSolver::factor(const VectorRef& error, const MatrixRef& P) {
  wide_ = P.rows() > SmallCholesky::kMost;
  if (wide_) {
    if (lead_rows_.rows() != lead_ || lead_rows_.cols() != P.rows()) {
      lead_rows_ = Matrix::Identity(lead_, P.rows());
    }
    if (!panels_.compute(P, lead_rows_, error)) return false;
    whitened_ = panels_.whitened();
    return true;
  }
  if (!small_.compute(P)) return false;
  whitened_ = error;
  small_.solve_lower(whitened_);
  return true;
}

NeesValue NeesSolver::solve(const VectorRef& error, const MatrixRef& P) {
  const Index zeros = (P.diagonal().array() == 0.0).count();
  if (zeros == 0) {
    if (!factor(error, P)) return {};
  } else {
    kept_.clear();
    for (Index i = 0; i < P.rows(); ++i) {
      if (P(i, i) != 0.0) kept_.push_back(i);
    }
    P_kept_ = P(kept_, kept_);
    const Vector kept_error = error(kept_);
    if (!factor(kept_error, P_kept_)) return {};
  }
  const double value = whitened_.squaredNorm();
  if (std::isnan(value)) return {};
  return {value, whitened_.size()};
}

double NeesSolver::log_determinant() const {
  return wide_ ? panels_.log_determinant() : log_determinant_of_factor(small_.lower());
}

const Vector& NeesSolver::inverse_diagonal() {
  if (wide_) return panels_.inverse_diagonal();
  small_.inverse_diagonal(inverse_diagonal_);
  return inverse_diagonal_;
}

bool NeesSolver::well_conditioned(const MatrixRef& P) const {
  if (whitened_.size() != P.rows()) return false;
  for (Index i = 0; i < P.rows(); ++i) {
    if (!(pivot(i) * pivot(i) > least_pivot(P.rows()) * P(i, i))) return false;
  }
  return true;
}

double NeesSolver::without_lead() const {
  const Index n = whitened_.size();
  Matrix G = wide_ ? Matrix(panels_.W().transpose()) : Matrix(Matrix::Identity(n, lead_));
  if (!wide_) small_.lower().triangularView<Eigen::Lower>().solveInPlace(G);
  const Vector scale = G.colwise().norm();
  G.array().rowwise() /= scale.transpose().array();
  const Eigen::LLT<Matrix> J(G.transpose() * G);
  Vector along = G.transpose() * whitened_;
  J.matrixL().solveInPlace(along);
  return whitened_.squaredNorm() - along.squaredNorm();
}

double NeesSolver::noise_share(const std::vector<double>& variances) {
  const Vector& inverse = inverse_diagonal();
  const Index m = inverse.size(), d = std::ssize(variances);
  double trace = 0.0;
  for (Index i = 0; i < m; ++i) trace += variances[static_cast<std::size_t>(i % d)] * inverse[i];
  return trace / static_cast<double>(m);
}

double NeesSolver::noise_share(const MatrixRef& S, const MatrixRef& R) {
  const Index m = whitened_.size();
  if (R.rows() != m || S.rows() != m) return kNaN;
  if (R.isDiagonal(0.0)) return R.diagonal().dot(inverse_diagonal()) / static_cast<double>(m);
  return S.llt().solve(R).trace() / static_cast<double>(m);
}

}  // namespace credence
