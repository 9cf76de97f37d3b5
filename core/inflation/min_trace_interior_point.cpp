#include "core/inflation/min_trace_interior_point.h"

#include <algorithm>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {
namespace {

using Cholesky = Eigen::LLT<Matrix>;

/// The largest step t with C + t D ⪰ 0, at most 1 after staying `fraction` away from the boundary.
double step_length(const Cholesky& C, const Matrix& D, double fraction) {
  const Matrix half = C.matrixL().solve(D);
  const Matrix whole = C.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetrised(whole), Eigen::EigenvaluesOnly);
  const double least = eigen.eigenvalues()(0);
  if (!(least < 0.0)) return 1.0;
  return std::min(1.0, -fraction / least);
}

/// The Newton equations of X (E − O) = μ I in the unknown entries of E, one for each entry of a lower
/// triangle.
class NewtonSystem {
 public:
  explicit NewtonSystem(const std::vector<DiagonalBlock>& blocks) {
    for (const DiagonalBlock& b : blocks) {
      for (Index j = 0; j < b.size; ++j) {
        for (Index i = j; i < b.size; ++i) entries_.push_back({b.offset + i, b.offset + j});
      }
    }
  }

  /// Factors the matrix of dE ↦ the diagonal blocks of sym(X dE Z⁻¹), positive definite for X, Z ≻ 0.
  bool factor(const Matrix& X, const Matrix& Z_inverse) {
    const auto count = static_cast<Index>(entries_.size());
    Matrix M(count, count);
    for (Index q = 0; q < count; ++q) {
      const auto [c, d] = entry(q);
      for (Index p = q; p < count; ++p) {
        const auto [a, b] = entry(p);
        M(p, q) = 0.25 * (X(a, c) * Z_inverse(b, d) + X(a, d) * Z_inverse(b, c) + X(b, c) * Z_inverse(a, d) +
                          X(b, d) * Z_inverse(a, c));
      }
    }
    factor_.compute(M);
    return factor_.info() == Eigen::Success;
  }

  Matrix solve(const Matrix& right_side) const {
    const auto count = static_cast<Index>(entries_.size());
    Vector y(count);
    for (Index p = 0; p < count; ++p) y(p) = right_side(entry(p).row, entry(p).col);
    factor_.solveInPlace(y);
    Matrix dE = Matrix::Zero(right_side.rows(), right_side.cols());
    for (Index p = 0; p < count; ++p) {
      const auto [a, b] = entry(p);
      dE(a, b) = a == b ? y(p) : 0.5 * y(p);
      dE(b, a) = dE(a, b);
    }
    return dE;
  }

 private:
  struct Entry {
    Index row, col;
  };
  const Entry& entry(Index p) const { return entries_[static_cast<std::size_t>(p)]; }

  std::vector<Entry> entries_;
  Cholesky factor_;
};

/// ⟨E − O, X⟩, the duality gap of a feasible pair.
double gap(const Matrix& E, const Matrix& O, const Matrix& X) { return (E - O).cwiseProduct(X).sum(); }

/// One predictor-corrector step in place; false, and nothing changed, where a factorisation fails.
bool step(MinTraceInteriorPoint& at, const Matrix& O, NewtonSystem& newton) {
  const Index m = O.rows();
  const Matrix I = Matrix::Identity(m, m);
  const Cholesky chol_Z(at.E - O), chol_X(at.X);
  if (chol_Z.info() != Eigen::Success || chol_X.info() != Eigen::Success) return false;
  const Matrix Z_inverse = symmetrised(chol_Z.solve(I));
  if (!newton.factor(at.X, Z_inverse)) return false;

  // Predictor: straight to μ = 0. It tells how far the centre must be kept in view.
  Matrix dE = newton.solve(-I);
  Matrix dX = -at.X - symmetrised(at.X * dE * Z_inverse);
  const double mu = gap(at.E, O, at.X) / static_cast<double>(m);
  double step_E = step_length(chol_Z, dE, 0.99), step_X = step_length(chol_X, dX, 0.99);
  const double mu_predicted = gap(at.E + step_E * dE, O, at.X + step_X * dX) / static_cast<double>(m);
  double centring = std::clamp(mu_predicted / mu * (mu_predicted / mu), 1e-6, 1.0);
  if (std::min(step_E, step_X) < 0.2) centring = std::max(centring, 0.3);

  const Matrix second_order = symmetrised(dX * dE * Z_inverse);
  const Matrix target = centring * mu * Z_inverse - second_order;
  // X_jj = I is asked of the new X, which keeps rounding from piling up in the constraint.
  dE = newton.solve(target - I);
  dX = target - at.X - symmetrised(at.X * dE * Z_inverse);
  step_E = step_length(chol_Z, dE, 0.95);
  step_X = step_length(chol_X, dX, 0.95);
  const Matrix E = at.E + step_E * dE;
  const Matrix X = symmetrised(at.X + step_X * dX);
  if (Cholesky(E - O).info() != Eigen::Success || Cholesky(X).info() != Eigen::Success) return false;
  at.E = E;
  at.X = X;
  return true;
}

}  // namespace

MinTraceInteriorPoint min_trace_interior_point(const Matrix& O, const std::vector<DiagonalBlock>& blocks,
                                               const Matrix& E, double relative_gap) {
  constexpr Index kMaxSteps = 60;
  constexpr int kPatience = 3;
  MinTraceInteriorPoint at{E, Matrix::Identity(O.rows(), O.cols()), 0};
  NewtonSystem newton(blocks);
  MinTraceInteriorPoint best = at;
  double best_gap = gap(at.E, O, at.X);
  int stalled = 0;
  while (at.steps < kMaxSteps && stalled < kPatience && best_gap > relative_gap * best.E.trace()) {
    if (!step(at, O, newton)) break;
    ++at.steps;
    // Near a degenerate solution rounding wins in the end and later iterates are worse.
    const double now = gap(at.E, O, at.X);
    stalled = now < 0.5 * best_gap ? 0 : stalled + 1;
    if (now >= best_gap) continue;
    best = at;
    best_gap = now;
  }
  best.steps = at.steps;
  return best;
}

}  // namespace credence::internal
