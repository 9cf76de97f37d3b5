#include "analysis/stability/riccati_newton.h"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra/matrix_product.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/panel_cholesky.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr int kMaxNewtonSteps = 6;
constexpr int kMaxSquarings = 40;
constexpr double kFewestDigits = 1e-2;  // of a correction …
constexpr double kMostDigits = 1e-9;    // … of which the next one has the rest
constexpr double kAcceptable = 1e-8;    // a residual above it is no solution

/// X = A X Aᵀ + C by X ← X + A X Aᵀ, A ← A², with an error of `enough` of it. False when A is not stable: its
/// powers do not fall to zero.
bool smith_doubling(Matrix A, const Matrix& C, double enough, Matrix& X) {
  const double largest = C.cwiseAbs().maxCoeff();
  const double size = largest > 0.0 ? largest : 1.0;  // nothing to correct still asks whether A is stable
  Matrix sum = C / size, product;
  MatrixProduct multiply;
  for (int k = 0; k < kMaxSquarings; ++k) {
    // Factors are packed fastest by the columns of the left one and those of the right one's transpose.
    multiply.set(product, A, ProductFactor::transposed(sum));
    multiply.add_lower(sum, product, ProductFactor::transposed(A));
    mirror_lower(sum);
    if (!std::isfinite(sum.norm())) return false;
    // The rest of the sum is at most ‖A²‖² of what there is.
    const double square = A.squaredNorm();
    if (square * square <= enough) {
      X = size * sum;
      return true;
    }
    multiply.set(product, A, A);
    A.swap(product);
  }
  return false;
}

}  // namespace

RiccatiResidual riccati_residual(const RiccatiProblem& problem, const Matrix& P) {
  const Index m = problem.H.rows();
  RiccatiResidual result;
  MatrixProduct multiply;
  Matrix FP;
  multiply.set(FP, problem.F, ProductFactor::transposed(P));
  result.defect = problem.Qt - P;
  multiply.add_lower(result.defect, FP, ProductFactor::transposed(problem.F));
  result.closed_loop = problem.F;
  if (m > 0) {
    const ProductFactor Ht = ProductFactor::transposed(problem.H);
    Matrix PHt, FPHt, S = problem.R;
    multiply.set(PHt, P, Ht);
    multiply.add_lower(S, problem.H, PHt);
    multiply.set(FPHt, FP, Ht);
    PanelCholesky cholesky;
    if (!cholesky.compute(S, FPHt, Vector::Zero(m))) result.defect.setConstant(kNaN);
    const Matrix W = cholesky.W(), FK = cholesky.gain();
    multiply.add_lower(result.defect, ProductFactor::minus(W), ProductFactor::transposed(W));
    multiply.add(result.closed_loop, ProductFactor::minus(FK), problem.H);
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
    const double enough = std::clamp(0.1 * target / residual.relative, kMostDigits, kFewestDigits);
    if (!smith_doubling(residual.closed_loop, residual.defect, enough, X)) return false;
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
