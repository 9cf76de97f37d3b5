#include "analysis/stability/noise_condition.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <stdexcept>

#include "analysis/stability/dense_svd.h"
#include "core/linear_algebra/psd_root.h"

namespace credence::internal {
namespace {

/// C with Q_t = C Cᵀ, as many columns as its rank, which may be 0.
Matrix range_root(const Matrix& Qt) {
  Matrix range = psd_range(Qt);
  if (range.cols() == 0) return range;
  return range * psd_root(range.transpose() * Qt * range);
}

/// R^{-1/2} H: measurements with unit noise.
Matrix whitened_observation(const RiccatiProblem& problem) {
  if (problem.H.rows() == 0) return problem.H;
  const Eigen::LLT<Matrix> root(problem.R);
  return root.matrixL().solve(problem.H);
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

NoiseCondition noise_condition(const RiccatiProblem& problem, MatrixRef P0) {
  require_valid(problem, P0);
  const Index n = problem.state_dim();
  if (!problem.F.isIdentity(0.0)) {
    throw std::invalid_argument("the noise condition is about states that stand still: F must be I");
  }
  NoiseCondition result;
  result.noise = psd_rank(problem.Qt);
  const Matrix C = range_root(problem.Qt), H = whitened_observation(problem);
  const DenseSvd svd = dense_svd(H * C, SvdVectors::full_right);
  result.seen = decide_rank(svd.s);

  // H C = U diag(s) Vᵀ: M = C (H C)⁺, and S = C N Nᵀ Cᵀ with N the columns of V that are not seen.
  const Index seen = result.seen.rank;
  const Matrix back = C * svd.V.leftCols(seen) * svd.s.head(seen).cwiseInverse().asDiagonal();
  const Matrix U = H * back;
  const Matrix M = back * U.transpose();
  const Matrix unseen = C * svd.V.rightCols(C.cols() - seen);
  const Matrix Psi = Matrix::Identity(n, n) - M * H;
  result.B = Psi * P0 * Psi.transpose() + M * M.transpose();
  result.S = unseen * unseen.transpose();
  if (unseen.cols() == 0) return result;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(result.S);
  result.rate = eigen.eigenvalues()[n - 1];
  result.direction = eigen.eigenvectors().col(n - 1);
  return result;
}

}  // namespace credence
