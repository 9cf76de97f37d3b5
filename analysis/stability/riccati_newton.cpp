#include "analysis/stability/riccati_newton.h"

#include <cmath>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_product.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {
namespace {

constexpr int kMaxNewtonSteps = 6;
constexpr int kMaxSquarings = 40;
constexpr double kEnough = 1e-9;      // digits of a correction: the next one has the rest
constexpr double kAcceptable = 1e-8;  // a residual above it is no solution

/// X = A X Aᵀ + C by X ← X + A X Aᵀ, A ← A². False when A is not stable: its powers do not fall to zero.
bool smith_doubling(Matrix A, const Matrix& C, Matrix& X) {
  const double largest = C.cwiseAbs().maxCoeff();
  const double size = largest > 0.0 ? largest : 1.0;  // nothing to correct still asks whether A is stable
  Matrix sum = C / size, product, added(A.rows(), A.cols());
  MatrixProduct multiply;
  for (int k = 0; k < kMaxSquarings; ++k) {
    multiply.set(product, sum, ProductFactor::transposed(A));
    added.setZero();
    multiply.add_lower(added, A, product);
    mirror_lower(added);
    sum += added;
    if (!std::isfinite(sum.norm())) return false;
    multiply.set(product, A, A);
    A.swap(product);
    // The rest of the sum is at most ‖A‖² of what there is, once ‖A‖ < 1.
    if (A.squaredNorm() <= kEnough) {
      X = size * sum;
      return true;
    }
  }
  return false;
}

}  // namespace

RiccatiResidual riccati_residual(const RiccatiProblem& problem, const Matrix& P) {
  const Index n = problem.state_dim();
  RiccatiResidual result;
  MatrixProduct multiply;
  Matrix FP;
  multiply.set(FP, problem.F, P);
  result.defect = problem.Qt - P;
  multiply.add_lower(result.defect, FP, ProductFactor::transposed(problem.F));
  result.closed_loop = problem.F;
  if (problem.H.rows() > 0) {
    const Matrix PHt = P * problem.H.transpose();
    Matrix S = problem.H * PHt + problem.R;
    const Eigen::LLT<Matrix> llt(S);
    result.K = llt.solve(PHt.transpose()).transpose();
    const Matrix FPHt = FP * problem.H.transpose();
    const Matrix E = llt.matrixL().solve(FPHt.transpose());
    result.defect.triangularView<Eigen::Lower>() -= E.transpose() * E;
    result.closed_loop.noalias() -= (problem.F * result.K) * problem.H;
  } else {
    result.K = Matrix(n, 0);
  }
  mirror_lower(result.defect);
  const double size = P.norm() > 0.0 ? P.norm() : problem.Qt.norm();
  result.relative = size > 0.0 ? result.defect.norm() / size : 0.0;
  return result;
}

bool newton_refine(const RiccatiProblem& problem, Matrix& P, RiccatiResidual& residual, double target) {
  residual = riccati_residual(problem, P);
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    Matrix X;
    if (!smith_doubling(residual.closed_loop, residual.defect, X)) return false;
    const Matrix improved = P + X;
    RiccatiResidual after = riccati_residual(problem, improved);
    const bool much_better = after.relative < 0.1 * residual.relative;
    if (after.relative < residual.relative) {
      P = improved;
      residual = std::move(after);
    }
    if (residual.relative <= target || !much_better) break;
  }
  return residual.relative <= kAcceptable;
}

}  // namespace credence::internal
