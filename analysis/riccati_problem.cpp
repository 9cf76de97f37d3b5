#include "analysis/riccati_problem.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>
#include <stdexcept>

#include "core/mirror.h"

namespace credence {
namespace {

void require_shape(const char* name, MatrixRef M, Index rows, Index cols) {
  if (M.rows() != rows || M.cols() != cols) {
    throw std::invalid_argument(
        fmt::format("{} is {}x{} and must be {}x{}", name, M.rows(), M.cols(), rows, cols));
  }
  if (!M.allFinite()) throw std::invalid_argument(fmt::format("{} has an entry that is not finite", name));
}

void require_symmetric(const char* name, MatrixRef M) {
  const double asymmetry = (M - M.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-9 * M.cwiseAbs().maxCoeff()) {
    throw std::invalid_argument(
        fmt::format("{} is not symmetric: two entries differ by {:g}", name, asymmetry));
  }
}

void require_psd(const char* name, MatrixRef M) {
  require_symmetric(name, M);
  const double slack = 1e-9 * M.cwiseAbs().maxCoeff();
  Matrix shifted = M;
  shifted.diagonal().array() += slack + std::numeric_limits<double>::min();
  if (shifted.llt().info() == Eigen::Success) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(M, Eigen::EigenvaluesOnly);
  throw std::invalid_argument(
      fmt::format("{} is not positive semidefinite: eigenvalue {:g}", name, eigen.eigenvalues().minCoeff()));
}

}  // namespace

void require_valid(const RiccatiProblem& problem, MatrixRef P0) {
  const Index n = problem.F.rows();
  const Index m = problem.H.rows();
  if (n == 0) throw std::invalid_argument("a Riccati problem needs at least one state");
  require_shape("F", problem.F, n, n);
  require_shape("H", problem.H, m, n);
  require_shape("Qt", problem.Qt, n, n);
  require_shape("R", problem.R, m, m);
  require_shape("P0", P0, n, n);
  require_psd("Qt", problem.Qt);
  require_psd("P0", P0);
  if (m == 0) return;
  require_symmetric("R", problem.R);
  if (problem.R.llt().info() != Eigen::Success) throw std::invalid_argument("R is not positive definite");
}

Matrix riccati_step(const RiccatiProblem& problem, MatrixRef P) {
  const Matrix FP = problem.F * P;
  Matrix next = FP * problem.F.transpose() + problem.Qt;
  if (problem.H.rows() > 0) {
    const Matrix S = problem.H * P * problem.H.transpose() + problem.R;
    const Matrix FPHt = FP * problem.H.transpose();
    const Eigen::LLT<Matrix> llt(S);
    const Matrix E = llt.matrixL().solve(FPHt.transpose());
    next -= E.transpose() * E;
  }
  return 0.5 * (next + next.transpose());
}

}  // namespace credence
