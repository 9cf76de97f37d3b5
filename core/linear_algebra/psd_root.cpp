#include "core/linear_algebra/psd_root.h"

#include "core/linear_algebra/decompositions.h"

namespace credence {

Matrix psd_root(const Matrix& A) {
  const Eigen::LLT<Matrix> llt(A);
  if (llt.info() == Eigen::Success) return llt.matrixL();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Matrix psd_whitening(const Matrix& A, double tolerance) {
  const Index n = A.rows();
  const Eigen::LLT<Matrix> llt(A);
  if (llt.info() == Eigen::Success) {
    return llt.matrixL().solve(Matrix::Identity(n, n));
  }
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  const double least = tolerance * std::max(0.0, eigen.eigenvalues().maxCoeff());
  const Index rank = (eigen.eigenvalues().array() > least).count();
  // Eigenvalues ascend: the last `rank` are kept.
  return eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
         eigen.eigenvectors().rightCols(rank).transpose();
}

}  // namespace credence
