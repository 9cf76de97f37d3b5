#include "core/linear_algebra/psd_root.h"

#include <cmath>

#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

constexpr double kNoVariance = 1e-28;  // of that before

/// Whether a factor's pivots are more than rounding.
bool is_regular(const Eigen::LLT<Matrix>& llt, const Matrix& A, double tolerance) {
  if (llt.info() != Eigen::Success) return false;
  const auto pivots = llt.matrixLLT().diagonal().array().square();
  return (pivots > tolerance * A.diagonal().array()).all();
}

/// A of states that all have a variance, each in units of its standard deviation.
Matrix unit_diagonal(const Matrix& A) {
  const Vector scale = A.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * A * scale.asDiagonal();
}

/// Over states that all have a variance.
Matrix whitening_of_states(const Matrix& A, double tolerance) {
  const Index n = A.rows();
  if (n == 0) return Matrix(0, 0);
  const Eigen::LLT<Matrix> llt(A);
  if (is_regular(llt, A, tolerance)) return llt.matrixL().solve(Matrix::Identity(n, n));
  const Vector scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(unit_diagonal(A));
  const double least = tolerance * std::max(0.0, eigen.eigenvalues().maxCoeff());
  const Index rank = (eigen.eigenvalues().array() > least).count();
  // Eigenvalues ascend: the last `rank` are kept.
  return eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
         eigen.eigenvectors().rightCols(rank).transpose() * scale.asDiagonal();
}

}  // namespace

Matrix psd_root(const Matrix& A) {
  const Eigen::LLT<Matrix> llt(A);
  if (llt.info() == Eigen::Success) return llt.matrixL();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

bool is_psd(const Matrix& A, double tolerance) {
  if (!A.allFinite() || (A.diagonal().array() < 0.0).any()) return false;
  const std::vector<Index> states = states_with_variance(A, Vector::Zero(A.rows()));
  for (Index i = 0; i < A.rows(); ++i) {
    if (A(i, i) == 0.0 && !A.row(i).isZero(0.0)) return false;
  }
  if (states.empty()) return true;
  const Matrix kept = A(states, states);
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(unit_diagonal(kept), Eigen::EigenvaluesOnly);
  return eigen.info() == Eigen::Success &&
         eigen.eigenvalues().minCoeff() >= -tolerance * eigen.eigenvalues().maxCoeff();
}

std::vector<Index> states_with_variance(MatrixRef A, VectorRef before) {
  std::vector<Index> states;
  for (Index i = 0; i < A.rows(); ++i) {
    if (A(i, i) > 0.0 && A(i, i) > kNoVariance * before[i]) states.push_back(i);
  }
  return states;
}

void clear_rounded_variances(Matrix& A, const VectorRef& before) {
  for (Index i = 0; i < A.rows(); ++i) {
    if (!(std::abs(A(i, i)) <= kNoVariance * before[i])) continue;
    A.row(i).setZero();
    A.col(i).setZero();
  }
}

Matrix psd_whitening(const Matrix& A, double tolerance) {
  return psd_whitening(A, Vector::Zero(A.rows()), tolerance);
}

Matrix psd_whitening(const Matrix& A, VectorRef before, double tolerance) {
  const std::vector<Index> states = states_with_variance(A, before);
  if (std::ssize(states) == A.rows()) return whitening_of_states(A, tolerance);
  const Matrix of_states = whitening_of_states(A(states, states), tolerance);
  Matrix whitening = Matrix::Zero(of_states.rows(), A.rows());
  whitening(Eigen::all, states) = of_states;
  return whitening;
}

}  // namespace credence::internal
