#include "analysis/stability/riccati.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/stability/riccati_marginal.h"
#include "analysis/stability/riccati_newton.h"
#include "analysis/stability/riccati_scaling.h"
#include "core/enum_words.h"
#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/matrix_product.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr int kMaxRegularDoublings = 14;
// Θ is in error by about the square of its last change, the next one by its fourth power; a Newton step then
// squares the error again, up to the digits of its correction.
constexpr double kStopAfterNextChange = 1e-2;
constexpr double kStopChange = 1e-4;
constexpr double kSmallTransition = 0.9;  // ‖A‖ of a marginal problem stays above 1
constexpr double kHopeless = 1e8;

/// Sees early that ‖A‖ has stopped falling: a marginal mode, which no doubling will move.
class StallDetector {
 public:
  bool stalled(double norm) {
    count_ = norm > 0.95 * last_ ? count_ + 1 : 0;
    last_ = norm;
    return count_ >= 4;
  }

 private:
  double last_ = std::numeric_limits<double>::infinity();
  int count_ = 0;
};

/// Structured doubling, then Newton; also F − F K H. False when there is no certificate of a stabilising
/// solution.
bool solve_regular(const RiccatiProblem& problem, RiccatiSolution& solution, Matrix& closed_loop) {
  RiccatiMap map(problem);
  StallDetector detector;
  while (map.doublings() < kMaxRegularDoublings) {
    const double trace_before = map.Theta().trace();
    if (!map.square()) return false;
    const double norm = map.A().norm();
    if (norm > kHopeless || detector.stalled(norm)) return false;
    const double change = map.last_change();
    if (norm > kSmallTransition || change > kStopAfterNextChange) continue;
    Matrix P = change > kStopChange ? map.next_Theta() : map.Theta();
    RiccatiResidual residual;
    if (!newton_refine(problem, P, residual)) continue;
    // The certificate: a stable closed loop, next to where doubling from P = 0 was going. Then every P0 goes
    // there.
    if (!((P - map.Theta()).norm() <= 0.01 * P.norm())) continue;
    solution.kind = RiccatiKind::stabilising;
    solution.stays_bounded = true;
    solution.residual = residual.relative;
    solution.growth_exponent = trace_before > 0.0 ? std::log2(P.trace() / map.Theta().trace()) : 0.0;
    solution.steps = std::exp2(map.doublings());
    solution.P = std::move(P);
    closed_loop = std::move(residual.closed_loop);
    return true;
  }
  return false;
}

Matrix filter_gain(const RiccatiProblem& problem, const Matrix& P) {
  if (problem.H.rows() == 0) return Matrix(problem.state_dim(), 0);
  Matrix PHt, S = problem.R;
  MatrixProduct multiply;
  multiply.set(PHt, P, ProductFactor::transposed(problem.H));
  multiply.add_lower(S, problem.H, PHt);
  const Eigen::LLT<Matrix> llt(S);
  return llt.solve(PHt.transpose()).transpose();
}

/// By falling modulus; empty when the iteration does not converge.
Eigen::VectorXcd eigenvalues_of(const Matrix& M) {
  const Eigen::EigenSolver<Matrix> eigen(M, false);
  if (eigen.info() != Eigen::Success) return {};
  Eigen::VectorXcd values = eigen.eigenvalues();
  std::sort(values.begin(), values.end(), [](auto a, auto b) {
    if (std::abs(a) != std::abs(b)) return std::abs(a) > std::abs(b);
    return std::arg(a) > std::arg(b);
  });
  return values;
}

void describe_closed_loop(const Matrix& closed_loop, RiccatiSolution& solution) {
  solution.closed_loop_eigenvalues = eigenvalues_of(closed_loop);
  solution.spectral_radius =
      solution.closed_loop_eigenvalues.size() > 0 ? std::abs(solution.closed_loop_eigenvalues[0]) : kNaN;
}

RiccatiSolution solve_scaled(const RiccatiProblem& problem, const ScaledRiccati& scaled,
                             const RiccatiOptions& options) {
  RiccatiSolution solution;
  Matrix closed_loop;
  const bool regular = solve_regular(scaled.problem, solution, closed_loop);
  if (!regular) solution = solve_marginal_riccati(scaled.problem, scaled.P0);
  if (options.closed_loop_eigenvalues) {
    if (!regular) closed_loop = riccati_residual(scaled.problem, solution.P).closed_loop;
    describe_closed_loop(closed_loop, solution);
  } else {
    solution.spectral_radius = kNaN;
  }
  solution.P = scaled.unscaled(solution.P);
  solution.K = filter_gain(problem, solution.P);
  return solution;
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

std::string_view to_string(RiccatiKind kind) {
  return word_of(kind, {"stabilising", "strong", "psd depending on P0", "oscillating", "none", "undecided"});
}

RiccatiSolution solve_riccati(const RiccatiProblem& problem, const Matrix& P0,
                              const RiccatiOptions& options) {
  require_valid(problem, P0);
  return solve_scaled(problem, scale_riccati(problem, P0), options);
}

RiccatiSolution solve_riccati(const RiccatiProblem& problem, const RiccatiOptions& options) {
  const Index n = problem.state_dim();
  require_valid(problem, Matrix::Zero(n, n));
  ScaledRiccati scaled = scale_riccati(problem, Matrix::Zero(n, n));
  scaled.P0.setIdentity();
  return solve_scaled(problem, scaled, options);
}

Eigen::VectorXcd closed_loop_eigenvalues(MatrixRef F, MatrixRef K, MatrixRef H) {
  const Matrix FKH = F * K * H;
  return eigenvalues_of(F - FKH);
}

}  // namespace credence
