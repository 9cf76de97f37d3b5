#include "analysis/riccati_newton.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "core/mirror.h"

namespace credence {
namespace {

constexpr int kMaxNewtonSteps = 6;
constexpr int kMaxSquarings = 40;
constexpr double kRoundingFloor = 1e-13;  // below this a step that fails to improve is rounding, not failure
constexpr double kAcceptable = 1e-8;      // a residual above it is no solution

/// X = A X Aᵀ + C by X ← X + A X Aᵀ, A ← A². False when A is not stable: its powers do not fall to zero.
template <typename Scalar>
bool smith_doubling(const Matrix& closed_loop, const Matrix& C, Matrix& X) {
  using M = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const double largest = C.cwiseAbs().maxCoeff();
  const double size = largest > 0.0 ? largest : 1.0;  // nothing to correct still asks whether A is stable
  M A = closed_loop.cast<Scalar>();
  M sum = (C / size).cast<Scalar>();
  M product(A.rows(), A.cols());
  const Scalar enough = std::numeric_limits<Scalar>::epsilon();
  for (int k = 0; k < kMaxSquarings; ++k) {
    product.noalias() = sum * A.transpose();
    M added = M::Zero(A.rows(), A.cols());
    added.template triangularView<Eigen::Lower>() += A * product;
    mirror_lower(added);
    sum += added;
    const Scalar norm = sum.norm();
    if (!std::isfinite(norm)) return false;
    product.noalias() = A * A;
    A.swap(product);
    // The rest of the sum is at most ‖A‖² of what there is, once ‖A‖ < 1.
    if (A.squaredNorm() <= enough) {
      X = size * sum.template cast<double>();
      return true;
    }
  }
  return false;
}

/// One correction; false when the closed loop is not stable.
bool correction(const RiccatiResidual& residual, bool single_precision, Matrix& X) {
  return single_precision ? smith_doubling<float>(residual.closed_loop, residual.defect, X)
                          : smith_doubling<double>(residual.closed_loop, residual.defect, X);
}

}  // namespace

RiccatiResidual riccati_residual(const RiccatiProblem& problem, const Matrix& P) {
  const Index n = problem.state_dim();
  RiccatiResidual result;
  Matrix FP(n, n);
  FP.noalias() = problem.F * P;
  result.defect = problem.Qt - P;
  result.defect.triangularView<Eigen::Lower>() += FP * problem.F.transpose();
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
  bool single_precision = true;
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    Matrix X;
    if (!correction(residual, single_precision, X)) {
      if (!single_precision) return false;
      single_precision = false;
      continue;
    }
    const Matrix improved = P + X;
    RiccatiResidual after = riccati_residual(problem, improved);
    const bool better = after.relative < residual.relative;
    const bool much_better = after.relative < 0.1 * residual.relative;
    if (better) {
      P = improved;
      residual = std::move(after);
    }
    if (residual.relative <= target) return true;
    if (much_better) continue;
    if (residual.relative <= kRoundingFloor || !single_precision) break;
    single_precision = false;
  }
  return residual.relative <= kAcceptable;
}

}  // namespace credence
