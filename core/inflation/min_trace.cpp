#include "core/inflation/min_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/inflation/min_trace_interior_point.h"
#include "core/inflation/pairwise_bound.h"
#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/polar.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

using Blocks = std::vector<DiagonalBlock>;
/// Solvers aim at this share of the gap asked for, so that rounding at the end does not cost convergence.
constexpr double kAim = 0.1;

Blocks blocks_of(const BlockLayout& layout) {
  Blocks blocks;
  blocks.reserve(static_cast<std::size_t>(layout.landmarks + 1));
  if (layout.vehicle > 0) blocks.push_back({0, layout.vehicle});
  for (Index i = 0; i < layout.landmarks && layout.landmark > 0; ++i) {
    blocks.push_back({layout.landmark_offset(i), layout.landmark});
  }
  return blocks;
}

Matrix without_diagonal_blocks(const MatrixRef& A, const Blocks& blocks) {
  Matrix O = A;
  for (const DiagonalBlock& b : blocks) O.block(b.offset, b.offset, b.size, b.size).setZero();
  return O;
}

/// Rows p of the factor V: with p(p+1)/2 above the number of constraints the factorised dual has, but for
/// special data, no false maxima ([Boumal 2016]); p = m is always enough.
Index factor_rows(const Blocks& blocks) {
  Index total = 0, constraints = 0, widest = 0;
  for (const DiagonalBlock& b : blocks) {
    total += b.size;
    constraints += b.size * (b.size + 1) / 2;
    widest = std::max(widest, b.size);
  }
  const auto enough = static_cast<Index>(std::ceil(std::sqrt(2.0 * static_cast<double>(constraints)))) + 1;
  return std::min(total, std::max(enough, 2 * widest));
}

/// Block-coordinate ascent on the dual: V_j ← polar factor of G_j = Σ_{k≠j} V_k O_kj, E_j = (G_jᵀG_j)^{1/2}.
class DualAscent {
 public:
  DualAscent(const Matrix& O, const Blocks& blocks, const BlockLayout& layout, const MinTraceState* warm)
      : O_(O), blocks_(blocks), V_(Matrix::Zero(factor_rows(blocks), O.rows())) {
    const Index kept = keep(layout, warm);
    // Random, but always the same: a start in general position, not a sample.
    std::mt19937_64 bits(0x6d696e2d7472u);
    for (const DiagonalBlock& b : blocks_) {
      if (b.offset < kept) continue;
      Matrix G(V_.rows(), b.size), scratch;
      for (double& entry : G.reshaped()) entry = std::ldexp(static_cast<double>(bits() >> 11), -52) - 1.0;
      polar<Eigen::Dynamic>(G, scratch, V_.middleCols(b.offset, b.size));
    }
  }

  /// One update of every block; returns Σ ‖V_j E_j − G_j‖ / Σ tr E_j, which is 0 at a maximum.
  double sweep() {
    double residual = 0.0, trace = 0.0;
    for (const DiagonalBlock& b : blocks_) {
      switch (b.size) {
        case 1: update<1>(b, residual, trace); break;
        case 2: update<2>(b, residual, trace); break;
        case 3: update<3>(b, residual, trace); break;
        default: update<Eigen::Dynamic>(b, residual, trace);
      }
    }
    return trace > 0.0 ? residual / trace : 0.0;
  }

  const Matrix& V() const { return V_; }

 private:
  Index keep(const BlockLayout& layout, const MinTraceState* warm) {
    if (warm == nullptr || warm->layout.vehicle != layout.vehicle ||
        warm->layout.landmark != layout.landmark || warm->layout.landmarks > layout.landmarks ||
        warm->V.rows() > V_.rows() || warm->V.cols() != warm->layout.state_dim()) {
      return 0;
    }
    V_.topLeftCorner(warm->V.rows(), warm->V.cols()) = warm->V;
    return warm->V.cols();
  }

  template <int D>
  void update(const DiagonalBlock& b, double& residual, double& trace) {
    using Columns = Eigen::Matrix<double, Eigen::Dynamic, D>;
    auto V = V_.middleCols<D>(b.offset, b.size);
    Columns G(V_.rows(), b.size), scratch;
    G.noalias() = V_.lazyProduct(O_.middleCols<D>(b.offset, b.size));
    const Columns before = V;
    const auto E = polar<D>(G, scratch, V_.middleCols<D>(b.offset, b.size));
    G.noalias() -= before.lazyProduct(E);
    residual += G.norm();
    trace += E.trace();
  }

  const Matrix& O_;
  const Blocks& blocks_;
  Matrix V_;
};

/// Moves E along its own diagonal to the boundary of E − O ⪰ 0: up where it is infeasible, down where it is
/// more than feasible. The equilibrated matrix makes this independent of the units of the states.
void make_feasible(Matrix& E, const Matrix& O) {
  const double largest = E.diagonal().maxCoeff();
  if (!(largest > 0.0)) return;
  const Vector weight = E.diagonal().cwiseMax(1e-8 * largest);
  const Vector scale = weight.cwiseSqrt().cwiseInverse();
  const Matrix slack = scale.asDiagonal() * (E - O) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(slack, Eigen::EigenvaluesOnly);
  // The computed eigenvalue may be above the true one by rounding; E must be feasible nevertheless.
  const double rounding = std::numeric_limits<double>::epsilon() * eigen.eigenvalues().cwiseAbs().maxCoeff();
  E.diagonal() -= (eigen.eigenvalues()(0) - rounding) * weight;
}

void set_gap(MinTraceBound& bound, const MinTraceOptions& options) {
  bound.primal = bound.E.trace();
  bound.relative_gap = bound.primal > 0.0 ? (bound.primal - bound.dual) / bound.primal : 0.0;
  bound.converged = bound.relative_gap <= options.relative_gap;
}

/// The bound that dual factors V prove: E from the same V, made feasible.
void certify(MinTraceBound& bound, const Matrix& V, const Matrix& O, const Blocks& blocks,
             const MinTraceOptions& options) {
  const Matrix G = V * O;
  bound.dual = G.cwiseProduct(V).sum();
  bound.E.setZero(O.rows(), O.cols());
  Matrix scratch, unused = V;
  for (const DiagonalBlock& b : blocks) {
    const Matrix G_j = G.middleCols(b.offset, b.size);
    bound.E.block(b.offset, b.offset, b.size, b.size) =
        polar<Eigen::Dynamic>(G_j, scratch, unused.middleCols(b.offset, b.size));
  }
  make_feasible(bound.E, O);
  set_gap(bound, options);
}

/// Ascends until the certificate holds, the sweeps are used up, or the rate says that they will be.
void ascend(MinTraceBound& bound, DualAscent& dual, const Matrix& O, const Blocks& blocks,
            const MinTraceOptions& options) {
  constexpr Index kWindow = 10;
  const bool finish = O.rows() <= options.max_interior_point_dim;
  // What an interior-point solution costs, in sweeps: crawling longer than that is waste.
  const Index patience =
      finish ? std::min(options.max_sweeps, 60 * O.rows() / dual.V().rows()) : options.max_sweeps;
  double wanted = kAim * options.relative_gap, window_start = std::numeric_limits<double>::infinity();
  bool certified = false;
  while (bound.sweeps < patience) {
    const double residual = dual.sweep();
    ++bound.sweeps;
    certified = residual <= wanted;
    if (certified) {
      certify(bound, dual.V(), O, blocks, options);
      if (bound.relative_gap <= kAim * options.relative_gap || wanted < 1e-15) return;
      wanted *= 0.1;
    }
    if (bound.sweeps % kWindow != 0) continue;
    const double factor = residual / window_start;
    window_start = residual;
    if (!finish || bound.sweeps < 3 * kWindow) continue;
    if (factor >= 1.0) break;
    const double windows_left = std::log(wanted / residual) / std::log(factor);
    if (windows_left * kWindow > static_cast<double>(patience - bound.sweeps)) break;
  }
  if (!certified) certify(bound, dual.V(), O, blocks, options);
}

/// X with X_jj = I made exact by a congruence of each block.
Matrix normalised(Matrix X, const Blocks& blocks) {
  for (const DiagonalBlock& b : blocks) {
    const Eigen::LLT<Matrix> root(X.block(b.offset, b.offset, b.size, b.size));
    const Matrix rows = root.matrixL().solve(X.middleRows(b.offset, b.size));
    X.middleRows(b.offset, b.size) = rows;
    const Matrix cols = root.matrixL().solve(X.middleCols(b.offset, b.size).transpose());
    X.middleCols(b.offset, b.size) = cols.transpose();
  }
  return X;
}

/// The factors nearest to X: its leading eigenvectors, orthonormalised block by block, for the next start.
Matrix factors_of(const Matrix& X, const Blocks& blocks, Index rows) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(X);
  const Vector roots = eigen.eigenvalues().tail(rows).cwiseMax(0.0).cwiseSqrt();
  const Matrix W = roots.asDiagonal() * eigen.eigenvectors().rightCols(rows).transpose();
  Matrix V = W, scratch;
  for (const DiagonalBlock& b : blocks) {
    const Matrix W_j = W.middleCols(b.offset, b.size);
    polar<Eigen::Dynamic>(W_j, scratch, V.middleCols(b.offset, b.size));
  }
  return V;
}

/// Replaces the bound by that of the interior point where this one is better; returns factors for a warm
/// start.
Matrix finish_inside(MinTraceBound& bound, const Matrix& O, const Matrix& pairwise, const Matrix& V,
                     const Blocks& blocks, const MinTraceOptions& options) {
  Matrix start = pairwise;
  const double largest = pairwise.diagonal().maxCoeff();
  for (const DiagonalBlock& b : blocks) {
    auto diagonal = start.diagonal().segment(b.offset, b.size);
    diagonal.array() += 0.1 * std::max(diagonal.mean(), 1e-8 * largest);
  }
  const MinTraceInteriorPoint inside =
      min_trace_interior_point(O, blocks, start, 0.2 * kAim * options.relative_gap);
  bound.interior_point_steps = inside.steps;

  const Matrix X = normalised(inside.X, blocks);
  MinTraceBound other = bound;
  other.E = inside.E;
  make_feasible(other.E, O);
  other.dual = O.cwiseProduct(X).sum();
  set_gap(other, options);
  // Each is feasible on its own side, so the better halves certify each other.
  if (!(other.primal <= bound.primal)) other.E = bound.E;
  other.dual = std::max(other.dual, bound.dual);
  set_gap(other, options);
  bound = other;
  return factors_of(X, blocks, V.rows());
}

void require(const MatrixRef& A, const BlockLayout& layout, const MinTraceOptions& options) {
  require_layout(A, layout);
  if (!(options.relative_gap > 0.0 && options.relative_gap < 1.0)) {
    throw std::invalid_argument(fmt::format("relative_gap = {} must lie in (0, 1)", options.relative_gap));
  }
  if (options.max_sweeps < 1) {
    throw std::invalid_argument(fmt::format("max_sweeps = {} must be at least 1", options.max_sweeps));
  }
}

MinTraceBound solve(Matrix O, const Blocks& blocks, const BlockLayout& layout, const MinTraceOptions& options,
                    MinTraceState* state) {
  MinTraceBound bound;
  bound.E = Matrix::Zero(O.rows(), O.cols());
  const double largest = O.size() == 0 ? 0.0 : O.cwiseAbs().maxCoeff();
  if (!std::isfinite(largest) || !O.allFinite()) {
    bound.E.setConstant(kNaN);
    bound.primal = bound.dual = bound.relative_gap = kNaN;
    return bound;
  }
  if (largest == 0.0) {
    bound.converged = true;
    return bound;
  }
  // A power of two, so that scaling costs no digit and no square over- or underflows.
  const double unit = std::ldexp(1.0, std::ilogb(largest));
  O /= unit;

  Matrix pairwise = O;
  decorrelate_pairwise(pairwise, layout);
  DualAscent dual(O, blocks, layout, state);
  ascend(bound, dual, O, blocks, options);
  Matrix V = dual.V();
  if (bound.relative_gap > kAim * options.relative_gap && O.rows() <= options.max_interior_point_dim) {
    V = finish_inside(bound, O, pairwise, V, blocks, options);
  }
  if (pairwise.trace() <= bound.primal) {
    bound.E = pairwise;
    set_gap(bound, options);
  }
  if (state != nullptr) *state = {layout, std::move(V)};
  bound.E *= unit;
  bound.primal *= unit;
  bound.dual *= unit;
  return bound;
}

}  // namespace

MinTraceBound min_trace_bound(const MatrixRef& A, const BlockLayout& layout, const MinTraceOptions& options,
                              MinTraceState* state) {
  require(A, layout, options);
  const Blocks blocks = blocks_of(layout);
  return solve(without_diagonal_blocks(A, blocks), blocks, layout, options, state);
}

MinTraceBound decorrelate_min_trace(Eigen::Ref<Matrix> A, const BlockLayout& layout,
                                    const MinTraceOptions& options, MinTraceState* state) {
  MinTraceBound bound = min_trace_bound(A, layout, options, state);
  for (const DiagonalBlock& b : blocks_of(layout)) {
    A.middleRows(b.offset, b.size).leftCols(b.offset).setZero();
    A.middleRows(b.offset, b.size).rightCols(A.cols() - b.offset - b.size).setZero();
    A.block(b.offset, b.offset, b.size, b.size) += bound.E.block(b.offset, b.offset, b.size, b.size);
  }
  return bound;
}

}  // namespace credence::internal
